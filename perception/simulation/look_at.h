// Where a camera has to be to look at something.
#pragma once

#include "collision/geometry/pose.h"

namespace cwm::perception {

// The optical frame C (z forward, x right, y down) at `eye_W`, looking at `target_W`, level: x is
// horizontal. Looking straight up or down, x points along the world's -y. The two points differ.
Pose LookAt(const Vector3& eye_W, const Vector3& target_W);

// How a camera looks at a target: from how far, how steeply down, and towards where.
struct ViewingDirection {
  double distance_m = 1;
  double down_rad = 0;     // of the optical axis below the horizon
  double azimuth_rad = 0;  // of the optical axis about z, from x
};

Pose LookAt(const Vector3& target_W, const ViewingDirection& view);

}  // namespace cwm::perception
