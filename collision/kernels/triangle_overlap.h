// Yes or no for single triangles, by separating axes (Gottschalk, Lin and Manocha 1996).
#pragma once

#include <array>

#include "collision/geometry/shape.h"

namespace cwm::collision {

using TrianglePoints = std::array<Vector3, 3>;

// Nearer than kUnsure of its size to touching, rounding could decide: somebody else should.
enum class Overlap { kNo, kYes, kUnsure };

Overlap TrianglesOverlap(const TrianglePoints& a, const TrianglePoints& b);
// The triangle in the frame of the solid box.
Overlap TriangleOverlapsBox(const TrianglePoints& triangle, const Box& box);

}  // namespace cwm::collision
