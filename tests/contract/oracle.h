// Independent proofs for answers about convex shapes: the extent along a direction, written from
// the definitions of the shapes, without code of the kernels.
#pragma once

#include "collision/geometry/shape.h"

namespace cwm::collision {

// True for all bounded convex shapes, whose extent is implemented here.
bool HasExtent(const Shape& shape);

// The maximum of direction . p over the points p of the shape placed at X_WS; `direction_W` is a
// unit vector.
double Extent_m(const Shape& shape, const Pose& X_WS, const Vector3& direction_W);

// The distance of B beyond A along the unit direction from A to B. The distance of disjoint convex
// A and B is its maximum over all directions, and the depth of overlapping ones is the minimum of
// its negative. An answer whose normal attains its distance is therefore a proven lower bound.
double Gap_m(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB,
             const Vector3& direction_W);

}  // namespace cwm::collision
