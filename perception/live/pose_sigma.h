// The uncertainty of a sensor's pose.
#pragma once

#include <cmath>

namespace cwm::perception {

// Standard deviations of a sensor's pose: of its place, and of its rotation about itself.
struct PoseSigma {
  double translation_m = 0;
  double rotation_rad = 0;

  // Of a point at this distance, metres.
  double At_m(double range_m) const { return std::hypot(translation_m, rotation_rad * range_m); }
};

}  // namespace cwm::perception
