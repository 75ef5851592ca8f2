// Which points of a cloud were measured.
#pragma once

#include <Eigen/Core>

namespace cwm::perception {

// Drivers tell of no return by coordinates that are not finite, or all zero: nothing is measured at
// the sensor itself. In the sensor's frame.
inline bool IsReturn(const Eigen::Vector3f& p) { return p.allFinite() && !p.isZero(0); }

}  // namespace cwm::perception
