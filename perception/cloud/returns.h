// Distinguishes measured points of a cloud from missing returns.
#pragma once

#include <Eigen/Core>

namespace cwm::perception {

// True if the point, in the sensor's frame, was measured. Drivers mark a missing return by
// coordinates that are not finite or all zero; nothing is measured at the sensor itself.
inline bool IsReturn(const Eigen::Vector3f& p) { return p.allFinite() && !p.isZero(0); }

}  // namespace cwm::perception
