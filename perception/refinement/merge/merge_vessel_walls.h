// Rims and corners cut a vessel that lies into its outside, its inside and its floor; segmentation
// does not know its axis (it joins those that stand: scene/join_vessels). Hypotheses that touch and
// make one shell are one object.
#pragma once

#include "perception/refinement/pass.h"

namespace cwm::perception {

class MergeVesselWalls : public RefinementPass {
 public:
  std::string_view Name() const override { return "merge.vessel_walls"; }
  Allowance MaxWork() const override;
  // Groups of small hypotheses that touch, each to become one.
  std::vector<Proposal> Propose(const SceneState& state,
                                const RefinementContext& context) const override;
  // Looks for the shell of a lying vessel in the group; those that do not lie on it stay out.
  std::optional<Proposal> Examine(const SceneState& state, Proposal proposal,
                                  const RefinementContext& context) const override;
  // One vessel, handles beside, that leaves little.
  bool Admits(const SceneState& state, const Proposal& proposal, std::size_t product,
              const ObjectModel& found) const override;
  double Gain(const SceneState& state, const Proposal& proposal,
              std::span<const ModelPtr> products) const override;
};

}  // namespace cwm::perception
