// Convex solids for a mesh: a hull around it, a hull inside it and balls inside it. They decide
// most overlap tests without looking at triangles.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "collision/kernels/convex_core.h"
#include "collision/kernels/inner_spheres.h"
#include "collision/kernels/triangle_tree.h"

namespace cwm::collision {

// The convex core of some points, with the arrays that it refers to.
class HullCore {
 public:
  explicit HullCore(std::vector<Vector3> vertices);
  HullCore(const HullCore&) = delete;
  HullCore& operator=(const HullCore&) = delete;

  const ConvexCore& core() const { return core_; }

 private:
  const std::vector<Vector3> vertices_;
  const VertexLanes lanes_;
  ConvexCore core_;
};

// Immutable.
class MeshHulls {
 public:
  // nullptr for a mesh that is flat, or so large that its hull would cost more than it saves.
  static std::unique_ptr<const MeshHulls> Make(const Mesh& mesh, const TriangleTree& tree,
                                               WorkCounter* work = nullptr);

  // The hull around the mesh. It contains every triangle up to a few roundings of its extent, and
  // its corners are corners of triangles.
  const ConvexCore& outer_hull() const { return outer_hull_.core(); }

  // The hull, shrunk about its centre just enough that it lies in the solid without a triangle in
  // its interior. A shape that overlaps it overlaps the mesh by far more than a rounding. nullptr
  // for an open mesh, or if the hull would have to shrink too far (a hollow in the middle).
  const ConvexCore* inner_hull() const { return inner_hull_ ? &inner_hull_->core() : nullptr; }

  // A larger hull in the solid, without a triangle in its interior: each face of the outer hull is
  // moved inwards by itself, no farther than its triangles need. It tells the depth of overlaps,
  // but may touch triangles. nullptr if there is no inner hull.
  const ConvexCore* depth_hull() const { return depth_hull_ ? &depth_hull_->core() : nullptr; }

  // Upper bound of the distance of any point of the outer hull from the inner one.
  double hull_gap_m() const { return hull_gap_m_; }

  // Balls in the solid, without a triangle on or in them. A shape that overlaps one overlaps the
  // mesh by far more than a rounding, and by whatever surface fills the holes that were closed.
  // Empty for an open mesh.
  const std::vector<InnerSphere>& inner_spheres() const { return inner_spheres_; }

 private:
  explicit MeshHulls(std::vector<Vector3> corners) : outer_hull_(std::move(corners)) {}

  HullCore outer_hull_;
  std::optional<HullCore> inner_hull_, depth_hull_;
  double hull_gap_m_ = 0;
  std::vector<InnerSphere> inner_spheres_;
};

// True or false if the hulls prove that a mesh and a convex solid, or two meshes, overlap or not;
// empty if they cannot decide. In the frame of A. The result of this and the following functions is
// always the one that the triangles would give.
std::optional<bool> HullsOverlap(const MeshHulls& a, const ConvexCore& b, const Pose& X_AB);
std::optional<bool> HullsOverlap(const MeshHulls& a, const MeshHulls& b, const Pose& X_AB);

// A mesh, with the centre of its box in the frame of a convex solid B.
struct CentredMesh {
  const MeshHulls& hulls;
  Vector3 centre_B = Vector3::Zero();
};
// The same by one corner and the inner balls, which is much faster and decides most pairs with a
// box, a cylinder or a capsule.
std::optional<bool> QuickOverlap(const CentredMesh& a, const ConvexCore& b, const Pose& X_AB,
                                 const Pose& X_BA);
// A mesh with its box.
struct BoxedMesh {
  const MeshHulls& hulls;
  const Aabb& bounds;
};
// True if a face of one mesh's box proves that the meshes are apart: the other mesh lies beyond it.
bool BoxFaceSeparates(const BoxedMesh& a, const BoxedMesh& b, const Pose& X_AB);

}  // namespace cwm::collision
