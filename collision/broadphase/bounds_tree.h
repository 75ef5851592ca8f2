// A static tree over axis-aligned boxes: who may be within a distance of a box, or on a ray.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <type_traits>
#include <vector>

#include "absl/container/inlined_vector.h"
#include "collision/geometry/aabb.h"

namespace cwm::collision {

// Square of the distance of two boxes, 0 when they overlap. Meaningless for empty boxes.
inline double SquaredDistance_m2(const Aabb& a, const Aabb& b) {
  const Eigen::Array3d gap = (a.min() - b.max()).array().max((b.min() - a.max()).array()).max(0.0);
  return gap.square().sum();
}

// Distance of two boxes, 0 when they overlap. Meaningless for empty boxes.
double Distance_m(const Aabb& a, const Aabb& b);

// A ray prepared for slab tests (Kay and Kajiya 1986). A direction component of 0 is handled
// exactly: such a ray stays between two slabs for ever or never gets there.
class SlabRay {
 public:
  SlabRay(const Vector3& origin, const Vector3& direction);

  // Length at which the ray enters the box, 0 when it starts inside, infinite when it misses.
  double Entry_m(const Aabb& box) const;

 private:
  Vector3 origin_;
  Vector3 inverse_;  // infinite where the direction has no component
};

// Immutable. Unbounded boxes (half-spaces) are allowed; empty boxes are never found. The same boxes
// in the same order make the same tree and the same order of visits.
class BoundsTree {
 public:
  BoundsTree() = default;
  explicit BoundsTree(std::span<const Aabb> boxes);

  // Calls visit(index) for each box within `distance_m` of `box` (touching counts), in no
  // particular order. A visitor that returns bool ends the walk by returning false.
  template <class Visit>
  void ForEachWithin(const Aabb& box, double distance_m, Visit&& visit) const;

  // Nearest first, equally near ones by index: visit(index, lower_bound_m) returns the distance
  // beyond which nothing matters any more (its best answer so far); boxes farther away are skipped.
  template <class Visit>
  void ForEachNearest(const Aabb& box, double max_distance_m, Visit&& visit) const;

  // Boxes hit by a ray, nearest entry first; visit(index, entry_m) returns the length that still
  // matters. The direction need not be unit; lengths are in its units.
  template <class Visit>
  void ForEachOnRay(const Vector3& origin, const Vector3& direction, double max_distance_m,
                    Visit&& visit) const;

  // Number of boxes given, the empty ones included.
  std::size_t size() const { return size_; }

 private:
  // An inner node has its left child right behind it and its right child at `second`; a leaf holds
  // the boxes [second, second + count) of the leaf order.
  struct Node {
    Aabb bounds;
    std::uint32_t second = 0;
    std::uint32_t count = 0;  // 0: inner node
  };

  // A node or (is_box) a box that waits in the queue of a best-first walk.
  struct Waiting {
    double key;
    std::uint32_t index;
    bool is_box;

    // The later one in a walk. Nodes go before boxes of the same key, so that equally near boxes
    // are known before the first of them is visited.
    friend bool operator<(const Waiting& a, const Waiting& b) {
      if (a.key != b.key) return a.key > b.key;
      if (a.is_box != b.is_box) return a.is_box;
      return a.index > b.index;
    }
  };

  // `key(bounds)` is the quantity that grows along the walk; it may not shrink from a node to what
  // is in it.
  template <class Key, class Visit>
  void BestFirst(double limit, const Key& key, Visit&& visit) const;

  std::uint32_t Build(std::vector<std::uint32_t>& order, std::size_t begin, std::size_t end,
                      std::span<const Aabb> boxes);

  std::size_t size_ = 0;
  std::vector<Node> nodes_;       // depth first
  std::vector<Aabb> leaf_boxes_;  // the boxes in the order of the leaves, then the unbounded
  std::vector<std::uint32_t> leaf_index_;  // what each of them is called by the caller
  std::size_t bounded_count_ = 0;          // of leaf_boxes_, those in the tree
};

template <class Visit>
void BoundsTree::ForEachWithin(const Aabb& box, double distance_m, Visit&& visit) const {
  const double limit_m2 = distance_m < 0 ? -1 : distance_m * distance_m;
  const auto call = [&](std::size_t leaf) {
    if (SquaredDistance_m2(box, leaf_boxes_[leaf]) > limit_m2) return true;
    if constexpr (std::is_same_v<decltype(visit(leaf_index_[leaf])), bool>) {
      return visit(leaf_index_[leaf]);
    } else {
      visit(leaf_index_[leaf]);
      return true;
    }
  };
  for (std::size_t leaf = bounded_count_; leaf < leaf_boxes_.size(); ++leaf) {
    if (!call(leaf)) return;
  }
  if (nodes_.empty()) return;
  absl::InlinedVector<std::uint32_t, 64> stack = {0};
  while (!stack.empty()) {
    const std::uint32_t at = stack.back();
    stack.pop_back();
    const Node& node = nodes_[at];
    if (SquaredDistance_m2(box, node.bounds) > limit_m2) continue;
    if (node.count == 0) {
      stack.push_back(node.second);
      stack.push_back(at + 1);
      continue;
    }
    for (std::size_t leaf = node.second; leaf < node.second + node.count; ++leaf) {
      if (!call(leaf)) return;
    }
  }
}

template <class Key, class Visit>
void BoundsTree::BestFirst(double limit, const Key& key, Visit&& visit) const {
  // Room for the walks of a few hundred boxes without a heap allocation.
  absl::InlinedVector<Waiting, 96> queue;
  const auto push = [&](double k, std::uint32_t index, bool is_box) {
    if (!(k <= limit)) return;
    queue.push_back({k, index, is_box});
    std::push_heap(queue.begin(), queue.end());
  };
  const auto push_boxes = [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) push(key(leaf_boxes_[i]), leaf_index_[i], true);
  };
  push_boxes(bounded_count_, leaf_boxes_.size());
  if (!nodes_.empty()) push(key(nodes_[0].bounds), 0, false);
  while (!queue.empty()) {
    std::pop_heap(queue.begin(), queue.end());
    const Waiting next = queue.back();
    queue.pop_back();
    if (next.key > limit) return;  // all that waits is at least as far
    if (next.is_box) {
      limit = std::min<double>(limit, visit(next.index, next.key));
      continue;
    }
    const Node& node = nodes_[next.index];
    if (node.count > 0) {
      push_boxes(node.second, node.second + node.count);
      continue;
    }
    push(key(nodes_[next.index + 1].bounds), next.index + 1, false);
    push(key(nodes_[node.second].bounds), node.second, false);
  }
}

template <class Visit>
void BoundsTree::ForEachNearest(const Aabb& box, double max_distance_m, Visit&& visit) const {
  BestFirst(
      max_distance_m, [&](const Aabb& other) { return std::sqrt(SquaredDistance_m2(box, other)); },
      visit);
}

template <class Visit>
void BoundsTree::ForEachOnRay(const Vector3& origin, const Vector3& direction,
                              double max_distance_m, Visit&& visit) const {
  const SlabRay ray(origin, direction);
  // A miss is infinite; a limit that is infinite too must not let it in.
  const double limit_m = std::min(max_distance_m, std::numeric_limits<double>::max());
  BestFirst(
      limit_m, [&](const Aabb& box) { return ray.Entry_m(box); }, visit);
}

}  // namespace cwm::collision
