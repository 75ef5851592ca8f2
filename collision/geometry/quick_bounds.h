// Bounds of placed shapes at a cost that does not depend on the shape, for objects that move often.
#pragma once

#include "collision/geometry/aabb.h"

namespace cwm {

// True if the cost of TightBounds grows with the vertices of the shape: a mesh, a hull or a plate.
bool HasManyVertices(const Shape& shape);
// Bounds in frame F of a box aligned with the axes of frame O. Not tight around the shape inside
// the box, but cheap.
Aabb BoundsOfBox(const Aabb& box_O, const Pose& X_FO);

}  // namespace cwm
