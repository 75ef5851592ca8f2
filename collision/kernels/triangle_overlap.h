// Overlap tests for single triangles, by separating axes (Gottschalk, Lin and Manocha 1996).
#pragma once

#include <array>

#include "collision/geometry/shape.h"

namespace cwm::collision {

using TrianglePoints = std::array<Vector3, 3>;

// kUnsure if the pair is so near to touching that rounding could decide; the caller then needs
// another test.
enum class Overlap { kNo, kYes, kUnsure };

Overlap TrianglesOverlap(const TrianglePoints& a, const TrianglePoints& b);
// The triangle is given in the frame of the solid box.
Overlap TriangleOverlapsBox(const TrianglePoints& triangle, const Box& box);

}  // namespace cwm::collision
