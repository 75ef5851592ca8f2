// Axis-aligned bounds, as tight as the placed shape allows.
#pragma once

#include "collision/geometry/shape.h"

namespace cwm {

using Aabb = Eigen::AlignedBox3d;

// The smallest axis-aligned box in frame F around a shape S placed at X_FS, exact for every shape.
// A half-space reaches to infinity, except where its normal is an axis of F.
Aabb TightBounds(const Shape& shape, const Pose& X_FS);

// Whether TightBounds has as much to do as the shape has vertices: a mesh, a hull, a plate.
bool HasManyVertices(const Shape& shape);
// Around a box that lies along the axes of frame O: not tight, but soon told.
Aabb BoundsOfBox(const Aabb& box_O, const Pose& X_FO);

}  // namespace cwm
