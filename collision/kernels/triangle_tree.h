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

// Distance of two boxes, 0 when they overlap.
double BoxGap_m(const Aabb& a, const Aabb& b);

// Immutable; the triangles are copied in the order of the tree.
class TriangleTree {
 public:
  // Boxes of the nodes: children of node i are i + 1 and `right`, or triangles [first, first +
  // count) when count is not 0.
  struct Node {
    Aabb bounds;
    double radius_m = 0;  // no corner is farther from the box's centre
    std::int32_t right = 0;
    std::int32_t first = 0;
    std::int32_t count = 0;
  };

  // At least one triangle. `is_turned` tells those whose winding is the other way round; empty: none.
  // Incomplete, not to be asked, where `work` ended it.
  explicit TriangleTree(const TriangleMesh& mesh, WorkCounter* work = nullptr);
  TriangleTree(const TriangleMesh& mesh, const std::vector<std::uint32_t>& components,
               const std::vector<bool>& is_turned, WorkCounter* work = nullptr);

  const std::vector<Node>& nodes() const { return nodes_; }
  const TriangleCorners& triangle(std::int32_t index) const {
    return triangles_[static_cast<std::size_t>(index)];
  }
  const Aabb& bounds() const { return nodes_.front().bounds; }
  // TightBounds of the mesh at a pose, by the few corners that may be the outermost.
  Aabb BoundsAt(const Pose& X_FS) const;
  const std::vector<TriangleCorners>& triangles() const { return triangles_; }

  // A point of each part of the surface that hangs together. Where no surfaces cross, a part lies
  // wholly inside or wholly outside of another solid, so that one point of it decides.
  const std::vector<Vector3>& component_points() const { return component_points_; }

  // Visits triangles that may be within a distance of a box, near subtrees first: visit(triangle,
  // index) returns the distance that still matters from then on; with a negative one only triangles
  // whose bounds overlap the box do, and kEnd ends the search, as `work` may.
  static constexpr double kEnd = -std::numeric_limits<double>::infinity();
  template <class Visit>
  void ForEachNear(const Aabb& box, double max_distance_m, Visit&& visit,
                   WorkCounter* work = nullptr) const {
    ForEachNearBy([&](const Node& node) { return BoxGap_m(node.bounds, box); }, max_distance_m,
                  visit, work);
  }
  // The same of what else bounds the distance to a node's triangles from below: bound_m(node).
  template <class Bound, class Visit>
  void ForEachNearBy(Bound&& bound_m, double max_distance_m, Visit&& visit,
                     WorkCounter* work = nullptr) const;

  // The nearest point of the triangles; `signed_distance_m` is positive on the side of its normal.
  struct Nearest {
    double distance_m = std::numeric_limits<double>::infinity();
    Vector3 point = Vector3::Zero();
    Vector3 face_normal = Vector3::UnitZ();
  };
  // As far as it was searched where `work` ends it.
  Nearest NearestPoint(const Vector3& p, double max_distance_m, WorkCounter* work = nullptr) const;

  // The first triangle hit by a ray, either side.
  std::optional<RayHit> CastRay(const Ray& ray, WorkCounter* work = nullptr) const;
  // Of a watertight mesh, where a ray first enters or leaves its solid: triangles within the solid,
  // where parts overlap, are none of its surface.
  std::optional<RayHit> CastRayAtSolid(const Ray& ray, WorkCounter* work = nullptr) const;

  // How often the surface of a watertight mesh winds around a point: 0 outside, 1 in a solid whose
  // normals point outward, -1 in one that is wound inward, more where parts overlap. By the
  // crossings of a ray, or by solid angles where the ray passes too near to an edge to be sure.
  int Winding(const Vector3& p, WorkCounter* work = nullptr) const;
  // Whether a point is in the solid of a watertight mesh: parts that overlap are a union, a part
  // within another one that faces the other way is a cavity, and a mesh that is wound inward is as
  // solid as its mirror image.
  bool Encloses(const Vector3& p, WorkCounter* work = nullptr) const {
    return Winding(p, work) != 0;
  }

  // Whether a point of the surface of a watertight mesh lies within its solid all the same. False
  // means that some point outside is within kBuried_m. `look` is where one is likely.
  static constexpr double kBuried_m = 1e-8;  // a tenth of what kExact promises
  bool Buries(const Vector3& p, const Vector3& look, WorkCounter* work = nullptr) const;

 private:
  // A triangle on a ray's way; nullptr: none.
  struct Crossed {
    const TriangleCorners* triangle = nullptr;
    double distance_m = 0;
    double clearance = 0;  // from the triangle's edges: the smallest barycentric coordinate
    bool leaves = false;   // the ray runs with the triangle's normal
    RayHit Hit() const { return {distance_m, triangle->Normal()}; }
  };
  std::int32_t Build(std::int32_t first, std::int32_t count, WorkCounter* work);
  void SplitAtMedian(std::int32_t first, std::int32_t count, Eigen::Index axis, WorkCounter* work);
  double Farthest(const Pose& X_FS, Eigen::Index axis, double sign) const;
  int WindingByAngles(const Vector3& p, WorkCounter* work) const;
  // The nearest, farther than `after_m`.
  Crossed FirstCrossed(const Ray& ray, double after_m, WorkCounter* work) const;
  // Of a ray without end how often it leaves the mesh more than it enters, nothing where it passes
  // too near to an edge to be sure, and the nearest triangle.
  struct AllCrossed {
    std::optional<int> turns;
    Crossed first;
  };
  AllCrossed CrossAll(const Vector3& origin, const Vector3& direction, WorkCounter* work) const;

  std::vector<TriangleCorners> triangles_;
  std::vector<Node> nodes_;
  std::vector<Vector3> component_points_;
};

// Splits at the median halve the count, so 32-bit counts make at most 32 levels; one entry waits
// per level.
inline constexpr int kTreeStack = 128;

template <class Bound, class Visit>
void TriangleTree::ForEachNearBy(Bound&& bound_m, double max_distance_m, Visit&& visit,
                                 WorkCounter* work) const {
  struct Entry {
    std::int32_t node;
    double gap;
  };
  std::array<Entry, kTreeStack> stack;
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
    stack[size++] = left;  // the nearer one comes off first
    stack[size++] = right;
  }
}

}  // namespace cwm::collision
