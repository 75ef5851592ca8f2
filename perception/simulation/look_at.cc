#include "perception/simulation/look_at.h"

#include <cmath>

namespace cwm::perception {

Pose LookAt(const Vector3& eye_W, const Vector3& target_W) {
  const Vector3 forward = (target_W - eye_W).normalized();
  constexpr double kLevel = 1e-9;  // sine of the angle to the vertical that still counts as such
  const Vector3 across(forward.y(), -forward.x(), 0);
  const Vector3 right = across.norm() > kLevel ? across.normalized() : Vector3(-Vector3::UnitY());
  Pose X_WC = Pose::Identity();
  X_WC.linear() << right, forward.cross(right), forward;
  X_WC.translation() = eye_W;
  return X_WC;
}

Pose LookAt(const Vector3& target_W, const ViewingDirection& view) {
  const double level = std::cos(view.down_rad);
  const Vector3 forward(level * std::cos(view.azimuth_rad), level * std::sin(view.azimuth_rad),
                        -std::sin(view.down_rad));
  return LookAt(target_W - view.distance_m * forward, target_W);
}

}  // namespace cwm::perception
