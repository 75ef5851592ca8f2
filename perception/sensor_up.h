// Compares the up of a sensor's pose with an up vector.
#pragma once

#include <cmath>

#include "collision/geometry/pose.h"
#include "perception/cloud/tolerances.h"

namespace cwm::perception {

// chosen: an up vector may be wrong by 3 degrees, as from an accelerometer on a moving robot, and
// an estimate of up by 1; a larger difference indicates another pose.
inline constexpr double kMaxUpError_rad = 5 * kDegree;

// The angle between the world's z and an up vector in the sensor's frame C, of any positive length,
// in [0, pi].
inline double AngleToUp_rad(const Pose& X_WC, const Vector3& up_C) {
  const Vector3 z_C = X_WC.linear().row(2).transpose();
  return std::atan2(z_C.cross(up_C).norm(), z_C.dot(up_C));
}

inline bool AgreesWithUp(const Pose& X_WC, const Vector3& up_C) {
  return AngleToUp_rad(X_WC, up_C) <= kMaxUpError_rad;
}

}  // namespace cwm::perception
