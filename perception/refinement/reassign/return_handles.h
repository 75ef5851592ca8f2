// What an occluder cuts off may stand out from another object, as a handle does: it is given back to
// the solid that it continues.
#pragma once

#include "perception/refinement/pass.h"

namespace cwm::perception {

// Proposes nothing where not all was seen from one place.
class ReturnHandles : public RefinementPass {
 public:
  std::string_view Name() const override { return "reassign.handles"; }
  Allowance MaxWork() const override;
  std::vector<Proposal> Propose(const SceneState& state,
                                const RefinementContext& context) const override;
  // The owner stays one solid.
  bool Admits(const SceneState& state, const Proposal& proposal, std::size_t product,
              const ObjectModel& found) const override;
  double Gain(const SceneState& state, const Proposal& proposal,
              std::span<const ModelPtr> products) const override;
};

}  // namespace cwm::perception
