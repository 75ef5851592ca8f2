#include "perception/segmentation/sight_map.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "perception/cloud/tolerances.h"
#include "perception/segmentation/surface_graph.h"

namespace cwm::perception {
namespace {

constexpr float kNothing = std::numeric_limits<float>::infinity();
// chosen: a map of this size takes 16 MiB.
constexpr int kMaxCellsPerSide = 2048;

// measured: the largest share of sampled points that may lie behind others. On full tables seen
// from one place it is 1.3 % in the median and 2.6 % at the ninth decile, at edges; in three merged
// views of the same tables 10 % in the median, and 2 % where objects hide little.
constexpr double kMaxBehind = 0.03;
// chosen: the size of a cell in this test, in cells of a map: bands along edges are as wide as a
// cell.
constexpr float kFiner = 1.0f / 3;

float SignOf(float v) { return v < 0 ? -1.0f : 1.0f; }

}  // namespace

SightMap::SightMap(const OrientedPoints& points, float pitch_rad)
    : viewpoint_(points.viewpoint.cast<float>()),
      cells_per_side_(static_cast<int>(
          std::clamp(2 / std::max(pitch_rad, 1e-4f), 16.0f, float{kMaxCellsPerSide}))) {
  const auto side = static_cast<std::size_t>(cells_per_side_);
  nearest_m_.assign(side * side, kNothing);
  for (const Eigen::Vector3f& p : points.points) {
    const Eigen::Vector3f ray = p - viewpoint_;
    float& nearest = nearest_m_[CellOf(ray)];
    nearest = std::min(nearest, ray.norm());
  }
}

std::size_t SightMap::CellOf(const Eigen::Vector3f& direction) const {
  const float sum = direction.cwiseAbs().sum();
  if (!(sum > 0)) return 0;
  float u = direction.x() / sum, v = direction.y() / sum;
  if (direction.z() < 0) {  // the lower half of the octahedron folds out
    const float folded = (1 - std::abs(v)) * SignOf(u);
    v = (1 - std::abs(u)) * SignOf(v);
    u = folded;
  }
  const float scale = 0.5f * static_cast<float>(cells_per_side_);
  const int column = std::clamp(static_cast<int>((u + 1) * scale), 0, cells_per_side_ - 1);
  const int row = std::clamp(static_cast<int>((v + 1) * scale), 0, cells_per_side_ - 1);
  return static_cast<std::size_t>(row) * static_cast<std::size_t>(cells_per_side_) +
         static_cast<std::size_t>(column);
}

Visibility SightMap::VisibilityAt(const Eigen::Vector3f& place, float tolerance_m) const {
  const Eigen::Vector3f ray = place - viewpoint_;
  const float nearest = nearest_m_[CellOf(ray)];
  const float range = ray.norm();
  if (nearest == kNothing) return Visibility::kNoReturn;
  if (nearest > range + tolerance_m) return Visibility::kSeenThrough;
  return nearest < range - tolerance_m ? Visibility::kHidden : Visibility::kOnSurface;
}

PlacesBetween CountBetween(const SightMap& sight, const OrientedPoints& points,
                           const std::vector<std::uint32_t>& a,
                           const std::vector<std::uint32_t>& b) {
  PlacesBetween counts;
  for (std::size_t line = 0; line < kLinesOfSight; ++line) {
    // evenly spread over both sets
    const std::uint32_t i = a[line * a.size() / kLinesOfSight];
    const std::uint32_t j = b[line * kLineStride % kLinesOfSight * b.size() / kLinesOfSight];
    for (int k = 1; k < kPlacesPerLineOfSight; ++k) {
      const float t = static_cast<float>(k) / kPlacesPerLineOfSight;
      const Eigen::Vector3f place = (1 - t) * points.points[i] + t * points.points[j];
      const Visibility at = sight.VisibilityAt(place, MaxJump_m(points.sigma_m[i]));
      ++counts.seen;
      counts.through += at == Visibility::kSeenThrough;
      counts.hidden += at == Visibility::kHidden;
    }
  }
  return counts;
}

bool IsSeenFromOnePlace(const OrientedPoints& points, float pitch_rad) {
  const SightMap sight(points, kFiner * pitch_rad);
  const std::size_t stride = 1 + points.size() / kMaxTestedNodes;
  std::size_t hidden = 0, asked = 0;
  for (std::size_t i = 0; i < points.size(); i += stride, ++asked) {
    const Eigen::Vector3f& p = points.points[i];
    // A slanted surface grows deeper across a cell.
    const float across_m = sight.pitch_rad() * (p - sight.viewpoint()).norm() / float{kGrazing_sin};
    const float tolerance_m = MaxJump_m(points.sigma_m[i]) + across_m;
    hidden += sight.VisibilityAt(p, tolerance_m) == Visibility::kHidden;
  }
  return static_cast<double>(hidden) <= kMaxBehind * static_cast<double>(asked);
}

}  // namespace cwm::perception
