#include "tests/perception/model/vessels.h"

#include <cmath>
#include <numbers>

namespace cwm::perception {
namespace {

constexpr double kSpacing_m = 0.002;
constexpr float kSigma_m = 0.0015f;

void Add(const Vector3& p, const Vector3& n, OrientedPoints& points) {
  points.points.push_back(p.cast<float>());
  points.normals.push_back(n.cast<float>());
  points.sigma_m.push_back(kSigma_m);
  points.normal_sigma_rad.push_back(0.1f);
  points.cloud_index.push_back(static_cast<std::uint32_t>(points.cloud_index.size()));
}

}  // namespace

void AddMug(const Vector2& axis, OrientedPoints& points) {
  for (double turn_rad = 0; turn_rad < 2 * std::numbers::pi;
       turn_rad += kSpacing_m / kMugRadius_m) {
    const Vector3 away(std::cos(turn_rad), std::sin(turn_rad), 0);
    for (double z = 0.005; z < kMugHeight_m; z += kSpacing_m) {
      const Vector3 middle(axis.x(), axis.y(), z);
      const bool outside = away.dot(points.viewpoint - middle) > 0;
      // The near rim hides the lower part of the inside.
      if (!outside && z < 0.4 * kMugHeight_m) continue;
      const double radius_m = outside ? kMugRadius_m : kMugRadius_m - kMugWall_m;
      Add(middle + radius_m * away, outside ? away : Vector3(-away), points);
    }
  }
}

void AddTube(const std::vector<Vector3>& middle, double thickness_m, OrientedPoints& points) {
  for (std::size_t k = 0; k + 1 < middle.size(); ++k) {
    const Vector3 along = (middle[k + 1] - middle[k]).normalized();
    const Vector3 to_sensor = (points.viewpoint - middle[k]).normalized();
    const Vector3 across = along.cross(to_sensor).normalized();
    const Vector3 towards = across.cross(along).normalized();
    const double length_m = (middle[k + 1] - middle[k]).norm();
    for (double way = 0; way < length_m; way += kSpacing_m) {
      for (double x = -0.5 * thickness_m; x <= 0.5 * thickness_m; x += kSpacing_m) {
        const double depth_m = std::sqrt(std::max(0.0, thickness_m * thickness_m / 4 - x * x));
        const Vector3 p = middle[k] + way * along + x * across;
        Add(p + depth_m * (towards.dot(to_sensor) > 0 ? towards : Vector3(-towards)),
            Vector3::Zero(), points);
      }
    }
  }
}

std::vector<Vector3> Ear() {
  std::vector<Vector3> middle;
  for (int k = 0; k <= 16; ++k) {
    const double turn_rad = std::numbers::pi * (k / 16.0 - 0.5);
    middle.emplace_back(0, kMugRadius_m + 0.03 * std::cos(turn_rad),
                        0.5 * kMugHeight_m + 0.03 * std::sin(turn_rad));
  }
  return middle;
}

}  // namespace cwm::perception
