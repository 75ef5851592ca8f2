// Bounds of placed shapes that cost the same whatever the shape: for what moves often.
#pragma once

#include "collision/geometry/aabb.h"

namespace cwm {

// Whether TightBounds has as much to do as the shape has vertices: a mesh, a hull, a plate.
bool HasManyVertices(const Shape& shape);
// Around a box that lies along the axes of frame O: not tight, but soon told.
Aabb BoundsOfBox(const Aabb& box_O, const Pose& X_FO);

}  // namespace cwm
