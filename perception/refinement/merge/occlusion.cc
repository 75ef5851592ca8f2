#include "perception/refinement/merge/occlusion.h"

#include <algorithm>
#include <cmath>

#include "perception/search/model_points.h"
#include "perception/segmentation/sight_map.h"
#include "perception/segmentation/surface_graph.h"
#include "perception/solids/explain.h"
#include "perception/solids/extended_distance.h"

namespace cwm::perception {
namespace {

Vector3 InSolid(const ShapePart& solid, const OrientedPoints& all, std::uint32_t point) {
  return solid.X_OS.inverse(Eigen::Isometry) * all.points[point].cast<double>();
}

}  // namespace

VisibilityShares VisibilityBetween(const SceneState& state, const PointSet& a, const PointSet& b) {
  const OrientedPoints& all = state.points();
  int through = 0, hidden = 0, seen = 0;
  for (std::size_t line = 0; line < kLinesOfSight; ++line) {
    const std::uint32_t i = a[line * a.size() / kLinesOfSight];
    const std::uint32_t j = b[line * kLineStride % kLinesOfSight * b.size() / kLinesOfSight];
    for (int k = 1; k < kPlacesPerLineOfSight; ++k) {
      const float t = static_cast<float>(k) / kPlacesPerLineOfSight;
      const Eigen::Vector3f place = (1 - t) * all.points[i] + t * all.points[j];
      const Visibility sight = state.sight()->VisibilityAt(place, MaxJump_m(all.sigma_m[i]));
      ++seen;
      through += sight == Visibility::kSeenThrough;
      hidden += sight == Visibility::kHidden;
    }
  }
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
