// Two convex solids for a mesh, one around it and one within, and balls within: most pairs are told by
// them alone.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "collision/kernels/convex_core.h"
#include "collision/kernels/inner_balls.h"
#include "collision/kernels/triangle_tree.h"

namespace cwm::collision {

// The hull of some points with what its core needs.
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
  // Nothing of a mesh that is flat, or so large that its hull would cost more than it saves.
  static std::unique_ptr<const MeshHulls> Of(const Mesh& mesh, const TriangleTree& tree,
                                             WorkCounter* work = nullptr);

  // Contains every triangle, but for a few roundings of its extent. Its corners are triangles'.
  const ConvexCore& around() const { return around_.core(); }

  // Lies in the solid, no point of its inside on a triangle: the hull, shrunk about its centre as
  // little as that takes. What overlaps it overlaps the mesh, by far more than a rounding. None of
  // an open mesh, nor of one whose hull has a hollow in the middle.
  const ConvexCore* within() const { return within_ ? &within_->core() : nullptr; }

  // No point of the hull around is farther from the one within.
  double wall_m() const { return wall_m_; }

  // In the solid, no triangle on or in one of them. What overlaps one overlaps the mesh, by far more
  // than a rounding. None of an open mesh.
  const std::vector<InnerBall>& balls_within() const { return balls_within_; }

 private:
  explicit MeshHulls(std::vector<Vector3> corners) : around_(std::move(corners)) {}

  LaneHull around_;
  std::optional<LaneHull> within_;
  double wall_m_ = 0;
  std::vector<InnerBall> balls_within_;
};

// Whether a mesh and a convex solid, or two meshes, overlap, where the hulls can tell; in the frame
// of A. What they tell is what the triangles would, and what all of these functions do.
std::optional<bool> HullsOverlap(const MeshHulls& a, const ConvexCore& b, const Pose& X_AB);
std::optional<bool> HullsOverlap(const MeshHulls& a, const MeshHulls& b, const Pose& X_AB);

// A mesh, the middle of its box and where that lies in the frame of a convex solid.
struct MeshMiddle {
  const MeshHulls& hulls;
  Vector3 middle_B = Vector3::Zero();
};
// The same by one corner and by balls within, much sooner, for most pairs with a box, a cylinder or a
// capsule.
std::optional<bool> CornerOrBallTells(const MeshMiddle& a, const ConvexCore& b, const Pose& X_AB,
                                      const Pose& X_BA);
// Whether a face of either's box, moved in to the mesh's foremost corner, shows two meshes to be apart.
struct BoxedMesh {
  const MeshHulls& hulls;
  const Aabb& bounds;
};
bool FaceParts(const BoxedMesh& a, const BoxedMesh& b, const Pose& X_AB);

}  // namespace cwm::collision
