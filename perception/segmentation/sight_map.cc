#include "perception/segmentation/sight_map.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "perception/cloud/tolerances.h"
#include "perception/segmentation/surface_graph.h"

namespace cwm::perception {
namespace {

constexpr float kNothing = std::numeric_limits<float>::infinity();
// chosen: a map of this size takes 16 MiB.
constexpr int kMaxCellsPerSide = 2048;

// measured: the largest share of points that may lie behind others in cells of a third of the rays'
// mean distance. In 36 simulated lists seen from one place (lasers, shuffled images) it is 0, in
// three merged views of the same scenes 0.4 to 6 %, and less where objects hide little.
constexpr double kMaxBehind = 0.0005;
constexpr double kFiner = 1.0 / 3;
// chosen: the solid angle of a cloud is that of the cells of this pitch with points; wider ones
// where they have fewer points than this on average.
constexpr float kCoarsePitch_rad = 0.02f;
constexpr double kMinPerCell = 8;
// chosen: rays of a large cloud that are tested.
constexpr std::size_t kMaxTestedRays = 300'000;

float SignOf(float v) { return v < 0 ? -1.0f : 1.0f; }

// A direction's place in the square of the octahedral projection, each coordinate from -1 to 1.
Eigen::Vector2f Octahedral(const Eigen::Vector3f& direction) {
  const float sum = direction.cwiseAbs().sum();
  if (!(sum > 0)) return Eigen::Vector2f::Zero();
  const float u = direction.x() / sum, v = direction.y() / sum;
  if (direction.z() >= 0) return {u, v};
  // The lower half of the octahedron folds out.
  return {(1 - std::abs(v)) * SignOf(u), (1 - std::abs(u)) * SignOf(v)};
}

// The number of a direction's cell.
std::uint64_t CellOf(const Eigen::Vector3f& direction, float pitch_rad) {
  const Eigen::Vector2f at = Octahedral(direction);
  const auto column = static_cast<std::uint64_t>((at.x() + 1) / pitch_rad);
  const auto row = static_cast<std::uint64_t>((at.y() + 1) / pitch_rad);
  return row << 32 | column;
}

// A hash of the number (the finalizer of SplitMix64).
std::uint64_t Scrambled(std::uint64_t x) {
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9;
  x = (x ^ (x >> 27)) * 0x94d049bb133111eb;
  return x ^ (x >> 31);
}

// The mean distance of neighbouring rays, if all of them come from the viewpoint.
double MeanRayDistance_rad(const OrientedPoints& points) {
  const std::size_t stride = 1 + points.size() / kMaxTestedRays;
  for (float pitch_rad = kCoarsePitch_rad;; pitch_rad *= 2) {
    std::vector<std::uint64_t> cells;
    for (std::size_t i = 0; i < points.size(); i += stride) {
      cells.push_back(CellOf(points.points[i] - points.viewpoint.cast<float>(), pitch_rad));
    }
    std::sort(cells.begin(), cells.end());
    const auto occupied = std::unique(cells.begin(), cells.end()) - cells.begin();
    const double per_cell = static_cast<double>(points.size()) / static_cast<double>(occupied);
    if (per_cell >= kMinPerCell || pitch_rad > 1) return pitch_rad / std::sqrt(per_cell);
  }
}

struct DirectedPoint {
  std::uint64_t cell = 0;
  float range_m = 0, sigma_m = 0;
};

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
  const Eigen::Vector2f at = Octahedral(direction);
  const float scale = 0.5f * static_cast<float>(cells_per_side_);
  const int column = std::clamp(static_cast<int>((at.x() + 1) * scale), 0, cells_per_side_ - 1);
  const int row = std::clamp(static_cast<int>((at.y() + 1) * scale), 0, cells_per_side_ - 1);
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

bool IsSeenFromOnePlace(const OrientedPoints& points) {
  const double pitch_rad = kFiner * MeanRayDistance_rad(points);
  std::vector<DirectedPoint> rays;
  const std::uint64_t every = 1 + points.size() / kMaxTestedRays;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3f ray = points.points[i] - points.viewpoint.cast<float>();
    const std::uint64_t cell = CellOf(ray, static_cast<float>(pitch_rad));
    // Whole cells are left out, so that points that hide each other stay together.
    if (every > 1 && Scrambled(cell) % every != 0) continue;
    rays.push_back({cell, ray.norm(), points.sigma_m[i]});
  }
  std::sort(rays.begin(), rays.end(), [](const DirectedPoint& a, const DirectedPoint& b) {
    return std::pair(a.cell, a.range_m) < std::pair(b.cell, b.range_m);
  });
  std::size_t hidden = 0;
  float nearest_m = 0;
  for (std::size_t k = 0; k < rays.size(); ++k) {
    if (k == 0 || rays[k].cell != rays[k - 1].cell) nearest_m = rays[k].range_m;
    // A slanted surface grows deeper across a cell.
    const float across_m =
        static_cast<float>(pitch_rad) * rays[k].range_m / static_cast<float>(kGrazing_sin);
    hidden += rays[k].range_m > nearest_m + MaxJump_m(rays[k].sigma_m) + across_m;
  }
  return static_cast<double>(hidden) <= kMaxBehind * static_cast<double>(rays.size());
}

}  // namespace cwm::perception
