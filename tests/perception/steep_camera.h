// A camera of small scenes.
#pragma once

#include "perception/simulation/virtual_scanner.h"

namespace cwm::perception {

// A camera at 0.9 m and 45 degrees; x of the image points to the world's -y.
inline PinholeCamera SteepCamera() {
  PinholeCamera camera;
  const Vector3 forward = Vector3(1, 0, -1).normalized(), right(0, -1, 0);
  camera.X_WC.linear() << right, forward.cross(right), forward;
  camera.X_WC.translation() = -0.9 * forward;
  return camera;
}

}  // namespace cwm::perception
