// The share of a solid's surface that measured points cover.
#pragma once

#include <algorithm>
#include <span>

#include "collision/geometry/shape.h"

namespace cwm::perception {

// Edge of the grid on which coverage is counted, of points `spacing_m` apart: twice that, and at
// least 4 mm. Chosen: two to three pixels of a Kinect at 0.8 m.
inline double CoverCell_m(double spacing_m) { return std::max(0.004, 2 * spacing_m); }

// Of the surface's area, on a grid of samples: covered where a point (in the shape's frame) lies
// in or beside the sample's cell. `cell_m` is at least the spacing of the points.
double ObservedFraction(const Shape& shape, std::span<const Eigen::Vector3f> points_S,
                        double cell_m);

}  // namespace cwm::perception
