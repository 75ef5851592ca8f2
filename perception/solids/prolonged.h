// Solids continued beyond their ends.
#pragma once

#include "collision/geometry/shape.h"

namespace cwm::perception {

// From p, in the shape's frame, to the nearest of its surfaces, each prolonged: the planes of a
// box's faces or a plate's top, the walls of cylinders and cones; of others the surface as it is.
// Metres.
double ProlongedDistance_m(const Shape& shape, const Vector3& p);

}  // namespace cwm::perception
