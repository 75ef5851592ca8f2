// Convex polyhedra for the shapes that FCL and Bullet lack.
#pragma once

#include <vector>

#include "collision/geometry/shape.h"

namespace cwm::collision {

// The union of the hulls contains the shape and reaches beyond it by at most `bound_m` (Hausdorff),
// so a signed distance computed from them is too small by at most `bound_m` per shape.
struct ConvexPieceSet {
  std::vector<TriangleMesh> hulls;
  double bound_m = 0;
};

// A prism or pyramid of regular polygons that circumscribe the discs of a truncated cone.
ConvexPieceSet CircumscribedPieces(const Cone& cone);

// Prisms that cover a plate exactly.
ConvexPieceSet CircumscribedPieces(const Plate& plate);

}  // namespace cwm::collision
