// Shapes that FCL and Bullet lack, as convex polyhedra that they have.
#pragma once

#include <vector>

#include "collision/geometry/shape.h"

namespace cwm::collision {

// The union of the hulls contains the shape and reaches beyond it by at most `bound_m` (Hausdorff),
// so signed distances computed from them are low by at most `bound_m` per shape.
struct ConvexPieceSet {
  std::vector<TriangleMesh> hulls;
  double bound_m = 0;
};

// A truncated cone inside a prism of regular polygons that touch its discs.
ConvexPieceSet CircumscribedPieces(const Cone& cone);

// The exact cover of a plate by prisms.
ConvexPieceSet CircumscribedPieces(const Plate& plate);

}  // namespace cwm::collision
