// Shapes in FCL's representation.
#pragma once

#include <fcl/geometry/collision_geometry.h>

#include <memory>
#include <vector>

#include "collision/engines/solid.h"
#include "collision/geometry/shape.h"

namespace cwm::collision {

// FCL's constructors of CollisionObject and its computeLocalAABB write to the shared geometry. All
// of that happens once, in MakeFclShape, and only const access is given out.
struct FclPiece {
  std::shared_ptr<const fcl::CollisionGeometryd> geometry;
  Pose X_SP = Pose::Identity();  // the piece in the shape's frame
};

struct FclShape {
  std::vector<FclPiece> pieces;
  double bound_m = 0;  // how far the pieces reach beyond the shape
};

// FCL's own types for half-space, sphere, box, capsule, cylinder and pointed cone; circumscribed
// convex pieces for a truncated cone and a plate; a hierarchy of OBBRSS for a mesh (AABB and k-DOP
// hierarchies copy the mesh on every query, and one without triangles crashes).
FclShape MakeFclShape(const Shape& shape);

}  // namespace cwm::collision
