// A scene whose hypotheses are put together by hand, without scanner and segmentation: points
// sampled on solids. For tests of single passes.
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

  // Adds a hypothesis of the visible points of these solids, on the table unless `support` is -1,
  // and returns its id. Every solid that hides a part of them must be known before (AddOccluder).
  HypothesisId Add(const std::vector<Placed<>>& solids, std::int32_t support = 0);
  // Adds a solid that hides what lies behind it. Its points belong to a hypothesis of its own,
  // which tests do not look at.
  HypothesisId AddOccluder(const Placed<>& solid);
  // Makes `upper` rest on `lower`, with its foot at this height.
  void Rest(HypothesisId upper, HypothesisId lower, double foot_height_m);

  // The hypotheses, without models. The sight map is known.
  SceneState State() const;
  // The same with models of these shapes: a point is explained by the nearest shape within 3 sigma.
  // Entries are in the order of ids; an empty entry leaves all points unexplained.
  SceneState StateWith(const std::vector<std::vector<Placed<>>>& shapes) const;
  // The same with the models that the modeler finds.
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

// An upright solid with its foot at this height above the table.
Placed<> Standing(const Shape& shape, double x_m, double y_m, double foot_m = 0,
                  double yaw_rad = 0);

// Runs one pass alone, as the driver does, on a state with models.
RefinedScene RunAlone(const SceneState& state, std::string_view pass);

// The proposals of one pass.
std::vector<Proposal> ProposalsOf(const SceneState& state, std::string_view pass);

}  // namespace cwm::perception
