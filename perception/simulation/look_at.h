// Poses of cameras that look at a target.
#pragma once

#include "collision/geometry/pose.h"

namespace cwm::perception {

// The optical frame C (z forward, x right, y down) at `eye_W`, looking at `target_W` with level x.
// If the view is vertical, x points along the world's -y. The two points must differ.
Pose LookAt(const Vector3& eye_W, const Vector3& target_W);

// The view of a target: distance, angle downwards, and azimuth.
struct ViewingDirection {
  double distance_m = 1;
  double down_rad = 0;     // of the optical axis below the horizon
  double azimuth_rad = 0;  // of the optical axis about z, from x
};

Pose LookAt(const Vector3& target_W, const ViewingDirection& view);

}  // namespace cwm::perception
