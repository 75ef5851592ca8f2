// Objects side by side, as books on a board or tins in a row, touch and are one to the segmentation;
// equal in height they leave little but their fronts to tell them apart.
#pragma once

#include "perception/refinement/pass.h"

namespace cwm::perception {

// Cuts an object by upright planes where its front jumps or turns outward, seen along the direction of
// its faces or along its greatest extent, where each part is one solid.
class SplitRows : public RefinementPass {
 public:
  std::string_view Name() const override { return "split.rows"; }
  std::span<const std::string_view> After() const override;
  Allowance MaxWork() const override;
  std::vector<Proposal> Propose(const SceneState& state,
                                const RefinementContext& context) const override;
  // One solid of nearly all points that stands.
  bool Admits(const SceneState& state, const Proposal& proposal, std::size_t product,
              const ObjectModel& found) const override;
  double Gain(const SceneState& state, const Proposal& proposal,
              std::span<const ModelPtr> products) const override;
};

}  // namespace cwm::perception
