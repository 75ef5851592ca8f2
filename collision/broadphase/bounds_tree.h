// A static tree over axis-aligned boxes: who may be within a distance of a box, or on a ray.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "collision/geometry/aabb.h"

namespace cwm::collision {

// Distance of two boxes, 0 when they overlap.
double Distance_m(const Aabb& a, const Aabb& b);

// Immutable. Unbounded boxes (half-spaces) are allowed; empty boxes are never found.
class BoundsTree {
 public:
  BoundsTree() = default;
  explicit BoundsTree(std::span<const Aabb> boxes);

  // Calls visit(index) for each box within `distance_m` of `box` (touching counts), in no
  // particular order.
  template <class Visit>
  void ForEachWithin(const Aabb& box, double distance_m, Visit&& visit) const;

  // Nearest first: visit(index, lower_bound_m) returns the distance beyond which nothing matters
  // any more (its best answer so far); subtrees farther away are skipped.
  template <class Visit>
  void ForEachNearest(const Aabb& box, double max_distance_m, Visit&& visit) const;

  // Boxes hit by a ray, nearest entry first; visit(index, entry_m) returns the length that still
  // matters.
  template <class Visit>
  void ForEachOnRay(const Vector3& origin, const Vector3& direction, double max_distance_m,
                    Visit&& visit) const;

  std::size_t size() const { return size_; }

 private:
  std::size_t size_ = 0;
};

}  // namespace cwm::collision
