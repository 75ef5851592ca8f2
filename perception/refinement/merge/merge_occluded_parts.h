// What stands before an object cuts it in two. Where the shape of a part suggests it, and nobody saw
// through between them, one solid is fitted to both: they are one object when it accounts for them.
#pragma once

#include "perception/refinement/pass.h"

namespace cwm::perception {

// Proposes nothing where not all was seen from one place.
class MergeOccludedParts : public RefinementPass {
 public:
  std::string_view Name() const override { return "merge.occluded_parts"; }
  std::span<const std::string_view> After() const override;
  Allowance MaxWork() const override;
  std::vector<Proposal> Propose(const SceneState& state,
                                const RefinementContext& context) const override;
  // One solid.
  bool Admits(const SceneState& state, const Proposal& proposal, std::size_t product,
              const ObjectModel& found) const override;
  double Gain(const SceneState& state, const Proposal& proposal,
              std::span<const ModelPtr> products) const override;
};

}  // namespace cwm::perception
