// The share of a solid's surface that measured points cover.
#pragma once

#include <span>

#include "collision/geometry/shape.h"

namespace cwm::perception {

// Of the surface's area, on a grid of samples: covered where a point (in the shape's frame) lies
// in or beside the sample's cell. `cell_m` is at least the spacing of the points.
double ObservedFraction(const Shape& shape, std::span<const Eigen::Vector3f> points_S,
                        double cell_m);

}  // namespace cwm::perception
