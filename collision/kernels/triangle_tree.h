// A tree of boxes over the triangles of a mesh, in the mesh's frame.
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "collision/geometry/aabb.h"
#include "collision/geometry/signed_distance.h"
#include "collision/kernels/exact.h"

namespace cwm::collision {

struct TriangleCorners {
  std::array<Vector3, 3> corners;
  Vector3 Normal() const;
};

// Distance of two boxes, 0 if they overlap.
double BoxDistance_m(const Aabb& a, const Aabb& b);

// Immutable; the triangles are copied in the order of the tree.
class TriangleTree {
 public:
  // The children of inner node i are i + 1 and `right`; a leaf (count > 0) holds the triangles
  // [first, first + count).
  struct Node {
    Aabb bounds;
    double radius_m = 0;  // largest distance of a corner from the box's centre
    std::int32_t right = 0;
    std::int32_t first = 0;
    std::int32_t count = 0;
  };

  // The mesh has at least one triangle. `is_turned` marks the triangles whose winding is to be
  // reversed; none if it is empty. The tree is incomplete and unusable if `work` ended it.
  explicit TriangleTree(const TriangleMesh& mesh, WorkCounter* work = nullptr);
  TriangleTree(const TriangleMesh& mesh, const std::vector<std::uint32_t>& components,
               const std::vector<bool>& is_turned, WorkCounter* work = nullptr);

  const std::vector<Node>& nodes() const { return nodes_; }
  const TriangleCorners& triangle(std::int32_t index) const {
    return triangles_[static_cast<std::size_t>(index)];
  }
  const Aabb& bounds() const { return nodes_.front().bounds; }
  // The same as TightBounds of the mesh at a pose, but visits only the corners that may be
  // outermost.
  Aabb BoundsAt(const Pose& X_FS) const;
  const std::vector<TriangleCorners>& triangles() const { return triangles_; }

  // One point of each connected component of the surface. If surfaces do not cross, a component
  // lies entirely inside or outside another solid, so one point decides.
  const std::vector<Vector3>& component_points() const { return component_points_; }

  // Visits triangles that may be within a distance of a box, near subtrees first. visit(triangle,
  // index) returns the maximum distance for the rest of the search; if that is negative, only
  // triangles whose bounds overlap the box are visited. kEnd ends the search, and so may `work`.
  static constexpr double kEnd = -std::numeric_limits<double>::infinity();
  template <class Visit>
  void ForEachNear(const Aabb& box, double max_distance_m, Visit&& visit,
                   WorkCounter* work = nullptr) const {
    ForEachNearBy([&](const Node& node) { return BoxDistance_m(node.bounds, box); }, max_distance_m,
                  visit, work);
  }
  // The same with any lower bound of the distance to a node's triangles: bound_m(node).
  template <class Bound, class Visit>
  void ForEachNearBy(Bound&& bound_m, double max_distance_m, Visit&& visit,
                     WorkCounter* work = nullptr) const;

  // The nearest point of the triangles. The distance is infinite if none is nearer than the limit.
  struct Nearest {
    double distance_m = std::numeric_limits<double>::infinity();
    Vector3 point = Vector3::Zero();
    Vector3 face_normal = Vector3::UnitZ();
  };
  // If `work` ends the search, the nearest point found so far.
  Nearest NearestPoint(const Vector3& p, double max_distance_m, WorkCounter* work = nullptr) const;

  // The first triangle hit by a ray, from either side.
  std::optional<RayHit> CastRay(const Ray& ray, WorkCounter* work = nullptr) const;
  // The point at which a ray first enters or leaves the solid of a watertight mesh. Triangles
  // inside the solid, where components overlap, are not part of its surface.
  std::optional<RayHit> CastRayAtSolid(const Ray& ray, WorkCounter* work = nullptr) const;

  // The winding number of a watertight mesh around a point: 0 outside, 1 in a solid whose normals
  // point outward, -1 in one that is wound inward, more where components overlap. Computed from the
  // crossings of a ray, or from solid angles if the ray passes too near to an edge to be certain.
  int Winding(const Vector3& p, WorkCounter* work = nullptr) const;
  // True if a point is in the solid of a watertight mesh. Overlapping components form a union, a
  // component inside another one with opposite winding is a cavity, and a mesh that is wound inward
  // has the same solid as one wound outward.
  bool Contains(const Vector3& p, WorkCounter* work = nullptr) const {
    return Winding(p, work) != 0;
  }

  // True if a point on a triangle of a watertight mesh is surrounded by its solid. False means that
  // some point outside the solid is within kInteriorTolerance_m. `first_direction` is tried first.
  static constexpr double kInteriorTolerance_m = 1e-8;  // a tenth of kExactTolerance_m
  bool IsInterior(const Vector3& p, const Vector3& first_direction,
                  WorkCounter* work = nullptr) const;

 private:
  // A triangle crossed by a ray; `triangle` is nullptr if there is none.
  struct RayCrossing {
    const TriangleCorners* triangle = nullptr;
    double distance_m = 0;
    double clearance = 0;  // smallest barycentric coordinate: distance from the triangle's edges
    bool leaves = false;   // the ray runs with the triangle's normal
    RayHit Hit() const { return {distance_m, triangle->Normal()}; }
  };
  std::int32_t Build(std::int32_t first, std::int32_t count, WorkCounter* work);
  void SplitAtMedian(std::int32_t first, std::int32_t count, Eigen::Index axis, WorkCounter* work);
  double Farthest(const Pose& X_FS, Eigen::Index axis, double sign) const;
  int WindingByAngles(const Vector3& p, WorkCounter* work) const;
  // The nearest triangle that the ray crosses at a distance above `after_m`.
  RayCrossing FindFirstCrossing(const Ray& ray, double after_m, WorkCounter* work) const;
  // The crossings of an endless ray: `turns` is how often it leaves the mesh minus how often it
  // enters, `first` the nearest triangle. Both empty if the ray passes too near to an edge to be
  // certain.
  struct RayCrossings {
    std::optional<int> turns;
    RayCrossing first;
  };
  RayCrossings FindAllCrossings(const Vector3& origin, const Vector3& direction,
                                WorkCounter* work) const;

  std::vector<TriangleCorners> triangles_;
  std::vector<Node> nodes_;
  std::vector<Vector3> component_points_;
};

// Capacity of a traversal stack. derived: splits at the median halve the count, so 32-bit counts
// make at most 32 levels, and one entry per level waits.
inline constexpr int kTreeStackSize = 128;

template <class Bound, class Visit>
void TriangleTree::ForEachNearBy(Bound&& bound_m, double max_distance_m, Visit&& visit,
                                 WorkCounter* work) const {
  struct Entry {
    std::int32_t node;
    double gap;
  };
  std::array<Entry, kTreeStackSize> stack;
  std::size_t size = 0;
  double limit = max_distance_m;
  stack[size++] = {0, bound_m(nodes_.front())};
  while (size > 0) {
    const Entry entry = stack[--size];
    if (entry.gap > std::max(limit, 0.0)) continue;
    if (MustEnd(work, 1)) return;
    const Node& node = nodes_[static_cast<std::size_t>(entry.node)];
    if (node.count > 0) {
      for (std::int32_t i = node.first; i < node.first + node.count; ++i) {
        limit = visit(triangle(i), i);
        if (limit == kEnd) return;
      }
      continue;
    }
    Entry left{entry.node + 1, 0}, right{node.right, 0};
    left.gap = bound_m(nodes_[static_cast<std::size_t>(left.node)]);
    right.gap = bound_m(nodes_[static_cast<std::size_t>(right.node)]);
    if (left.gap < right.gap) std::swap(left, right);
    stack[size++] = left;  // the nearer one is popped first
    stack[size++] = right;
  }
}

}  // namespace cwm::collision
