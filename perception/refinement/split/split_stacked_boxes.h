// Flat boxes on one another that leave only corners of each other to be seen: wherever things of boxes
// touch and are not in order, the stack is cut anew at the heights of its level faces.
#pragma once

#include "perception/refinement/pass.h"

namespace cwm::perception {

// Objects of boxes that touch and are not in order (one of them is not one box, begins in the air on
// nothing, or runs through another) become a box for each height at which level faces end, each on the
// one before, where each is one box and lies over the one below.
class SplitStackedBoxes : public RefinementPass {
 public:
  std::string_view Name() const override { return "split.stacked_boxes"; }
  std::span<const std::string_view> After() const override;
  Allowance MaxWork() const override;
  std::vector<Proposal> Propose(const SceneState& state,
                                const RefinementContext& context) const override;
  // One box of nearly all points: a layer that took points of what merely touches it is no better than
  // what was cut.
  bool Admits(const SceneState& state, const Proposal& proposal, std::size_t product,
              const ObjectModel& found) const override;
  double Gain(const SceneState& state, const Proposal& proposal,
              std::span<const ModelPtr> products) const override;
};

}  // namespace cwm::perception
