// What only looked like a handle: a ball or a round tin beside something stands by itself.
#pragma once

#include "perception/refinement/pass.h"

namespace cwm::perception {

// A handle that is one round solid, wider than handles are across, and stands on what its object stands
// on becomes an object of its own.
class SplitFalseHandles : public RefinementPass {
 public:
  std::string_view Name() const override { return "split.false_handles"; }
  std::span<const std::string_view> After() const override;
  Allowance MaxWork() const override;
  std::vector<Proposal> Propose(const SceneState& state,
                                const RefinementContext& context) const override;
  // Before the handle is modelled with all that was seen around it: whether one solid of it stands.
  std::optional<Proposal> Examine(const SceneState& state, Proposal proposal,
                                  const RefinementContext& context) const override;
  bool Admits(const SceneState& state, const Proposal& proposal, std::size_t product,
              const ObjectModel& found) const override;
  double Gain(const SceneState& state, const Proposal& proposal,
              std::span<const ModelPtr> products) const override;
};

}  // namespace cwm::perception
