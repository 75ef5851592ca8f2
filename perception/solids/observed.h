// The share of a solid's surface that measured points cover.
#pragma once

#include <algorithm>
#include <span>

#include "collision/geometry/shape.h"

namespace cwm::perception {

// Edge of the grid on which coverage is counted, for points `spacing_m` apart.
// chosen: twice the spacing and at least 4 mm, which are two to three pixels of a Kinect at 0.8 m.
inline double CoverCell_m(double spacing_m) { return std::max(0.004, 2 * spacing_m); }

// The share of the surface's area that is covered, counted on a grid of samples. A sample is
// covered if a point (in the shape's frame) lies in its cell or a neighbouring one. `cell_m` is at
// least the spacing of the points.
double ObservedFraction(const Shape& shape, std::span<const Eigen::Vector3f> points_S,
                        double cell_m);

}  // namespace cwm::perception
