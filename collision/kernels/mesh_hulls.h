// Two convex solids for a mesh, one around it and one within: most pairs are told by them alone.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "collision/kernels/convex_core.h"
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
  static std::unique_ptr<const MeshHulls> Of(const Mesh& mesh, const TriangleTree& tree);

  // Contains every triangle, but for a few roundings of its extent.
  const ConvexCore& around() const { return around_.core(); }

  // Lies in the solid, no point of its inside on a triangle: the hull, shrunk about its centre as
  // little as that takes. What overlaps it overlaps the mesh, by far more than a rounding. None of
  // an open mesh, nor of one whose hull has a hollow in the middle.
  const ConvexCore* within() const { return within_ ? &within_->core() : nullptr; }

  // No point of the hull around is farther from the one within.
  double wall_m() const { return wall_m_; }

 private:
  explicit MeshHulls(std::vector<Vector3> corners) : around_(std::move(corners)) {}

  LaneHull around_;
  std::optional<LaneHull> within_;
  double wall_m_ = 0;
};

// Whether a mesh and a convex solid, or two meshes, overlap, where the hulls can tell; in the frame
// of A. What they tell is what the triangles would.
std::optional<bool> HullsOverlap(const MeshHulls& a, const ConvexCore& b, const Pose& X_AB);
std::optional<bool> HullsOverlap(const MeshHulls& a, const MeshHulls& b, const Pose& X_AB);

}  // namespace cwm::collision
