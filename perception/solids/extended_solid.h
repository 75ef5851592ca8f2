// Extends boxes, cylinders and cones at one of their ends.
#pragma once

#include <optional>

#include "collision/geometry/shape.h"

namespace cwm::perception {

// One end of an axis of the shape's frame: sign is +1 for the end with positive coordinates.
struct SolidEnd {
  Eigen::Index axis = 2;
  double sign = 1;
};

// The length along the axis, in metres; empty for shapes other than boxes, cylinders and cones.
// Cylinders and cones have a length along z only.
std::optional<double> LengthAlong_m(const Shape& shape, Eigen::Index axis);

// The limit of an extension, in metres: of a cone that narrows toward this end, the distance to its
// apex; 0 for other shapes and axes.
double MaxExtension_m(const Shape& shape, const SolidEnd& end);

// Returns the solid with this end moved outward by by_m, which is less than MaxExtension_m. All
// other surfaces stay where they are.
Placed<> Extended(Placed<> solid, const SolidEnd& end, double by_m);

}  // namespace cwm::perception
