// An octree over points in Morton order (paper, section V): cells for localised sampling, and
// hierarchical pruning of those that cannot hold inliers.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "perception/model/model_points.h"

namespace cwm::perception {

// Immutable. Every node is a contiguous range of points; nodes are stored in preorder, so that a
// subtree is contiguous too.
class Octree {
 public:
  static constexpr std::uint32_t kNone = 0xffffffff;

  struct Node {
    CellBounds bounds;  // tight around the points
    std::uint32_t begin = 0, end = 0;
    std::uint32_t after = 0;  // the next node in preorder that is not below this one
    std::uint32_t parent = kNone;
    bool leaf = true;
  };

  explicit Octree(const ModelPoints& points);

  std::span<const Node> nodes() const { return nodes_; }
  // The cells around a point, leaf first, root last.
  std::vector<std::uint32_t> CellsAround(std::uint32_t point) const;
  std::uint32_t LeafOf(std::uint32_t point) const { return leaf_of_[point]; }

  // f(begin, end) for the leaves whose box the model may reach within `gate_m`.
  template <ShapeModel M, class F>
  void ForEachReached(const M& model, double gate_m, F&& f) const {
    for (std::uint32_t i = 0; i < nodes_.size();) {
      const Node& node = nodes_[i];
      if (!model.MayReach(node.bounds, gate_m)) {
        i = node.after;
        continue;
      }
      if (node.leaf) f(node.begin, node.end);
      ++i;
    }
  }

 private:
  std::uint32_t Build(const ModelPoints& points, std::uint32_t begin, std::uint32_t end, int shift,
                      std::uint32_t parent);

  std::vector<Node> nodes_;
  std::vector<std::uint32_t> leaf_of_;
};

// The points of `available` (one flag per point) within the gates of the model, ascending.
template <ShapeModel M>
std::vector<std::uint32_t> FindInliers(const M& model, const ModelPoints& points,
                                       const Octree& octree, const std::vector<char>& available,
                                       double gate_scale = 1) {
  std::vector<std::uint32_t> inliers;
  octree.ForEachReached(model, gate_scale * points.widest_gate_m,
                        [&](std::uint32_t begin, std::uint32_t end) {
                          for (std::uint32_t i = begin; i < end; ++i) {
                            if (available[i] && IsInlier(model, points, i, gate_scale))
                              inliers.push_back(i);
                          }
                        });
  return inliers;
}

}  // namespace cwm::perception
