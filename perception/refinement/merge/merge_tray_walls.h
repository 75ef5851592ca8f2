// The walls of an open box that show their inside, those that show their outside, and its floor, which
// is too near to what it stands on to be told from that, are one object.
#pragma once

#include "perception/refinement/pass.h"

namespace cwm::perception {

// Where lone walls are sides of an open box (FindTrays) and one sees into its mouth, what lies on its
// sides and its floor becomes one object, of the points of its support those within it among them: a
// box for each side and for the floor. A side that nobody saw is COMPLETED, or left out where rays
// pass. What stands in it rests on it. Proposes nothing where not all was seen from one place.
class MergeTrayWalls : public RefinementPass {
 public:
  std::string_view Name() const override { return "merge.tray_walls"; }
  std::span<const std::string_view> After() const override;
  Allowance MaxWork() const override;
  std::vector<Proposal> Propose(const SceneState& state,
                                const RefinementContext& context) const override;
  // The walls seen: they prove the tray, its shapes follow from them.
  double Gain(const SceneState& state, const Proposal& proposal,
              std::span<const ModelPtr> products) const override;
};

}  // namespace cwm::perception
