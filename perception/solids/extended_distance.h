// Distances to surfaces that are extended beyond their ends.
#pragma once

#include "collision/geometry/shape.h"

namespace cwm::perception {

// The distance in metres from p, in the shape's frame, to the nearest of its extended surfaces: the
// planes of a box's faces, the plane of a plate's top, the infinite walls of cylinders and cones.
// For other shapes, the distance to the surface itself.
double ExtendedDistance_m(const Shape& shape, const Vector3& p);

}  // namespace cwm::perception
