// Convex solids for a mesh: a hull around it, a hull inside it and balls inside it. They decide
// most overlap tests without looking at triangles.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "collision/kernels/convex_core.h"
#include "collision/kernels/inner_balls.h"
#include "collision/kernels/triangle_tree.h"

namespace cwm::collision {

// The convex core of some points, with the arrays that it refers to.
class LaneHull {
 public:
  explicit LaneHull(std::vector<Vector3> vertices);
  LaneHull(const LaneHull&) = delete;
  LaneHull& operator=(const LaneHull&) = delete;

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
  static std::unique_ptr<const MeshHulls> Of(const Mesh& mesh, const TriangleTree& tree,
                                             WorkCounter* work = nullptr);

  // The hull around the mesh. It contains every triangle up to a few roundings of its extent, and
  // its corners are corners of triangles.
  const ConvexCore& around() const { return around_.core(); }

  // The hull, shrunk about its centre just enough that it lies in the solid without a triangle in
  // its interior. A shape that overlaps it overlaps the mesh by far more than a rounding. nullptr
  // for an open mesh, or if the hull would have to shrink too far (a hollow in the middle).
  const ConvexCore* within() const { return within_ ? &within_->core() : nullptr; }

  // Upper bound of the distance of any point of the outer hull from the inner one.
  double wall_m() const { return wall_m_; }

  // Balls in the solid, without a triangle on or in them. A shape that overlaps one overlaps the
  // mesh by far more than a rounding. Empty for an open mesh.
  const std::vector<InnerBall>& balls_within() const { return balls_within_; }

 private:
  explicit MeshHulls(std::vector<Vector3> corners) : around_(std::move(corners)) {}

  LaneHull around_;
  std::optional<LaneHull> within_;
  double wall_m_ = 0;
  std::vector<InnerBall> balls_within_;
};

// True or false if the hulls prove that a mesh and a convex solid, or two meshes, overlap or not;
// empty if they cannot decide. In the frame of A. The result of this and the following functions is
// always the one that the triangles would give.
std::optional<bool> HullsOverlap(const MeshHulls& a, const ConvexCore& b, const Pose& X_AB);
std::optional<bool> HullsOverlap(const MeshHulls& a, const MeshHulls& b, const Pose& X_AB);

// A mesh, with the centre of its box in the frame of a convex solid B.
struct MeshMiddle {
  const MeshHulls& hulls;
  Vector3 middle_B = Vector3::Zero();
};
// The same by one corner and the inner balls, which is much faster and decides most pairs with a
// box, a cylinder or a capsule.
std::optional<bool> CornerOrBallTells(const MeshMiddle& a, const ConvexCore& b, const Pose& X_AB,
                                      const Pose& X_BA);
// A mesh with its box.
struct BoxedMesh {
  const MeshHulls& hulls;
  const Aabb& bounds;
};
// True if a face of one mesh's box proves that the meshes are apart: the other mesh lies beyond it.
bool FaceParts(const BoxedMesh& a, const BoxedMesh& b, const Pose& X_AB);

}  // namespace cwm::collision
