// The coefficient vectors that users of PCL know (pcl::SampleConsensusModel*), derived from a
// placed shape.
#pragma once

#include <vector>

#include "collision/geometry/shape.h"

namespace cwm {

// The coefficients in frame F and in PCL's order; empty for shapes for which PCL has no such model:
//   plane (plate, half-space)  n_x n_y n_z d           n . p + d = 0, top face
//   sphere                     c_x c_y c_z r
//   cylinder                   q_x q_y q_z a_x a_y a_z r      q on the axis, a unit
//   cone                       apex_x apex_y apex_z a_x a_y a_z half_angle_rad
//                              a points from the apex into the cone; empty when both radii are
//                              equal
std::vector<double> Coefficients(const Shape& shape, const Pose& X_FS);

}  // namespace cwm
