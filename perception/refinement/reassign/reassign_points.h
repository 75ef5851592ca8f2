// Objects that touch give each other points back: those that no shape of their owner explains and a
// shape of the neighbour does, and handles whose ends are on the neighbour's wall.
#pragma once

#include "perception/refinement/pass.h"

namespace cwm::perception {

class ReassignPoints : public RefinementPass {
 public:
  std::string_view Name() const override { return "reassign.points"; }
  std::span<const std::string_view> After() const override;
  Allowance MaxWork() const override;
  std::vector<Proposal> Propose(const SceneState& state,
                                const RefinementContext& context) const override;
  // How many more points have a shape than half of those that are given; nothing where a handle was
  // lost.
  double Gain(const SceneState& state, const Proposal& proposal,
              std::span<const ModelPtr> products) const override;
};

}  // namespace cwm::perception
