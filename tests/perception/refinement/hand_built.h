// A scene whose hypotheses are put together by hand: points sampled on solids, no scanner, no
// segmentation. For tests of single passes.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "perception/hypotheses/scene_state.h"
#include "perception/refinement/refine.h"

namespace cwm::perception {

// A table at z = 0, seen from (-0.8, -0.3, 0.8) in the level frame. Points are exact, lie where the
// sensor sees them, and claim a sigma of 1.5 mm.
class HandBuilt {
 public:
  HandBuilt();

  // A hypothesis of what is seen of the solids, on the table unless `support` is -1. All solids that
  // hide something of each other have to be known before: AddOccluder. Returns its id.
  HypothesisId Add(const std::vector<Placed<>>& solids, std::int32_t support = 0);
  // Hides what lies behind it; its points are of no hypothesis that a test looks at, but its own.
  HypothesisId AddOccluder(const Placed<>& solid);
  // Says what a hypothesis rests on.
  void Rest(HypothesisId upper, HypothesisId lower, double foot_height_m);

  // The hypotheses, without models. Sight is known.
  SceneState State() const;
  // The same with models that have these shapes: a point is explained by the nearest within 3 sigma.
  // Entries are in the order of ids; an empty one leaves all points unexplained.
  SceneState StateWith(const std::vector<std::vector<Placed<>>>& shapes) const;
  // The same with models as the modeler finds them.
  SceneState Modelled() const;

 private:
  struct Member {
    std::vector<Placed<>> solids;
    std::int32_t support = 0;
    std::optional<std::pair<HypothesisId, double>> on;
  };
  bool IsVisible(const Vector3& p, std::size_t member) const;
  void Sample(std::size_t member, OrientedPoints& points, SegmentedScene& scene) const;
  SegmentedScene Segmented() const;

  std::vector<Member> members_;
};

// An upright solid whose foot is at this height above the table.
Placed<> Standing(const Shape& shape, double x_m, double y_m, double foot_m = 0,
                  double yaw_rad = 0);

// Runs one pass alone, as the driver does, on a state with models.
RefinedScene RunAlone(const SceneState& state, std::string_view pass);

// The proposals of one pass.
std::vector<Proposal> ProposalsOf(const SceneState& state, std::string_view pass);

}  // namespace cwm::perception
