#include "perception/refinement/merge/occlusion.h"

#include <algorithm>
#include <cmath>

#include "perception/search/model_points.h"
#include "perception/segmentation/sight_map.h"
#include "perception/solids/explain.h"
#include "perception/solids/extended_distance.h"

namespace cwm::perception {
namespace {

Vector3 InSolid(const ShapePart& solid, const OrientedPoints& all, std::uint32_t point) {
  return solid.X_OS.inverse(Eigen::Isometry) * all.points[point].cast<double>();
}

}  // namespace

VisibilityShares VisibilityBetween(const SceneState& state, const PointSet& a, const PointSet& b) {
  const auto [through, hidden, seen] = CountBetween(*state.sight(), state.points(), a, b);
  return {static_cast<double>(through) / seen, static_cast<double>(hidden) / seen};
}

bool IsOnSolid(const ShapePart& solid, const OrientedPoints& all, std::uint32_t point) {
  return std::abs(SignedDistance_m(solid, InSolid(solid, all, point))) <=
         kDistanceGate_sigma * double{all.sigma_m[point]};
}

bool IsOnExtended(const ShapePart& solid, const OrientedPoints& all, std::uint32_t point) {
  return ExtendedDistance_m(solid.shape, InSolid(solid, all, point)) <=
         AssignmentTolerance_m(all.sigma_m[point]);
}

}  // namespace cwm::perception
