// Shapes as meshes, for pictures, exports and engines that lack the shape.
#pragma once

#include "collision/geometry/shape.h"

namespace cwm {

// A watertight outward-wound mesh of the shape in its own frame, its vertices on the surface (an
// inscribed mesh); round parts deviate from the surface by at most `max_deviation_m`. A half-space
// becomes a square of 20 m by 20 m and 1 m depth.
TriangleMesh Tessellate(const Shape& shape, double max_deviation_m = 5e-4);

}  // namespace cwm
