// Round objects on one axis, as cans, cups and bowls are stacked: they are one to the segmentation, and
// their solids are those of one object with a step. What could stand alone is an object of its own.
#pragma once

#include "perception/refinement/pass.h"

namespace cwm::perception {

// Cuts an object of upright solids of revolution where its radius jumps or its wall turns outward, into
// storeys that each rest on the one below. Storeys that are lower or slimmer than what people
// stack are lids, knobs, necks and feet: they stay with the storey below.
class SplitStackedRounds : public RefinementPass {
 public:
  std::string_view Name() const override { return "split.stacked_rounds"; }
  std::span<const std::string_view> After() const override;
  Allowance MaxWork() const override;
  std::vector<Proposal> Propose(const SceneState& state,
                                const RefinementContext& context) const override;
  // One solid of revolution of nearly all points.
  bool Admits(const SceneState& state, const Proposal& proposal, std::size_t product,
              const ObjectModel& found) const override;
  double Gain(const SceneState& state, const Proposal& proposal,
              std::span<const ModelPtr> products) const override;
};

}  // namespace cwm::perception
