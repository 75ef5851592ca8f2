// Independent certificates for answers about convex shapes: the farthest extent along a direction,
// written from the definitions of the shapes and sharing no code with the kernels.
#pragma once

#include "collision/geometry/shape.h"

namespace cwm::collision {

// Shapes whose extent is known here: all bounded convex ones.
bool HasExtent(const Shape& shape);

// max of direction . p over the points p of the shape placed at X_WS; direction is unit.
double Extent_m(const Shape& shape, const Pose& X_WS, const Vector3& direction_W);

// How far B lies beyond A along the unit direction from A to B. The distance of disjoint convex A
// and B is the maximum of it over all directions, and the depth of overlapping ones the least of
// its negative: an answer whose normal attains its distance is a proven lower bound.
double Gap_m(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB,
             const Vector3& direction_W);

}  // namespace cwm::collision
