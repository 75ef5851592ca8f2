#include "perception/scene/sight_map.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace cwm::perception {
namespace {

constexpr float kNothing = std::numeric_limits<float>::infinity();
constexpr int kMostCellsPerSide = 2048;  // 16 MiB

float SignOf(float v) { return v < 0 ? -1.0f : 1.0f; }

}  // namespace

SightMap::SightMap(const OrientedPoints& points, float pitch_rad)
    : viewpoint_(points.viewpoint.cast<float>()),
      cells_per_side_(static_cast<int>(
          std::clamp(2 / std::max(pitch_rad, 1e-4f), 16.0f, float{kMostCellsPerSide}))) {
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
  if (direction.z() < 0) {  // the lower half folds out
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

Visibility SightMap::Look(const Eigen::Vector3f& place, float tolerance_m) const {
  const Eigen::Vector3f ray = place - viewpoint_;
  const float nearest = nearest_m_[CellOf(ray)];
  const float range = ray.norm();
  if (nearest == kNothing) return Visibility::kNoReturn;
  if (nearest > range + tolerance_m) return Visibility::kSeenThrough;
  return nearest < range - tolerance_m ? Visibility::kHidden : Visibility::kOnSurface;
}

}  // namespace cwm::perception
