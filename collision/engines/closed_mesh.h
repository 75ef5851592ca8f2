// Inside and outside of a watertight mesh. FCL and Bullet know triangles only: a cup inside a
// closed cupboard touches none of them, so containment is tested here, once for both.
#pragma once

#include <memory>
#include <vector>

#include "collision/broadphase/bounds_tree.h"
#include "collision/geometry/triangle_mesh.h"

namespace cwm::collision {

// Immutable.
class ClosedMesh {
 public:
  explicit ClosedMesh(std::shared_ptr<const TriangleMesh> mesh);

  // Whether the mesh winds around the point; either answer within rounding of the surface.
  bool Contains(const Vector3& p) const;

 private:
  std::shared_ptr<const TriangleMesh> mesh_;
  BoundsTree triangles_;
};

// One vertex of each connected component of the mesh. Where no surfaces cross, a component lies
// wholly inside or wholly outside of another solid, so that one point of it decides.
std::vector<Vector3> ComponentPoints(const TriangleMesh& mesh);

}  // namespace cwm::collision
