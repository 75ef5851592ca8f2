// Boxes, cylinders and cones made longer at one of their ends.
#pragma once

#include <optional>

#include "collision/geometry/shape.h"

namespace cwm::perception {

// The end of an axis of the shape's frame: +1 where its coordinates are positive.
struct SolidEnd {
  Eigen::Index axis = 2;
  double sign = 1;
};

// Along the axis, of which cylinders and cones have z alone. Metres; nothing of other shapes.
std::optional<double> LengthAlong_m(const Shape& shape, Eigen::Index axis);

// By how much it can be: less than to its apex of a cone, 0 of other shapes and other axes.
double MostLonger_m(const Shape& shape, const SolidEnd& end);

// With that end farther out by less than MostLonger_m, all other surfaces where they are.
Placed<> Lengthened(Placed<> solid, const SolidEnd& end, double by_m);

}  // namespace cwm::perception
