// An octree over points in Morton order (paper, section V): cells for localised sampling, and
// hierarchical pruning of cells that cannot hold inliers.
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "perception/search/model_points.h"
#include "perception/search/point_lanes.h"

namespace cwm::perception {

// Immutable. Every node is a contiguous range of points; nodes are stored in preorder, so a subtree
// is contiguous too.
class Octree {
 public:
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

  struct Node {
    CellBounds bounds;  // tight around the points
    std::uint32_t begin = 0, end = 0;
    std::uint32_t after = 0;  // the next node in preorder that is not below this one
    std::uint32_t parent = kNone;
    bool leaf = true;
  };

  explicit Octree(const ModelPoints& points);

  std::span<const Node> nodes() const { return nodes_; }
  // The smallest cell around a point; its parents are the larger ones.
  std::uint32_t LeafOf(std::uint32_t point) const { return leaf_of_[point]; }
  const PointLanes& lanes() const { return lanes_; }  // all points, in order

  // Returns ascending ranges of points: those of the cells that the model may reach within
  // `gate_m`. Small cells are not split further.
  template <ShapeModel M>
  std::vector<PointLanes::Range> Reached(const M& model, double gate_m) const {
    std::vector<PointLanes::Range> ranges;
    for (std::uint32_t i = 0; i < nodes_.size();) {
      const Node& node = nodes_[i];
      const bool reached = model.MayReach(node.bounds, gate_m);
      const bool whole = node.leaf || node.end - node.begin <= kTestedAtOnce;
      if (reached && whole) {
        const bool follows = !ranges.empty() && ranges.back().end == node.begin;
        if (!follows) ranges.push_back({node.begin, node.begin});
        ranges.back().end = node.end;
      }
      i = reached && !whole ? i + 1 : node.after;
    }
    return ranges;
  }

 private:
  // chosen: smaller leaves need more box tests than the point tests they save.
  static constexpr std::uint32_t kLeafPoints = 8;
  // derived: as many groups of lanes: four points are tested in a third of the time of a box.
  static constexpr std::uint32_t kTestedAtOnce = kLeafPoints * PointLanes::kMaxLanes;

  std::uint32_t Build(const ModelPoints& points, std::uint32_t begin, std::uint32_t end, int shift,
                      std::uint32_t parent);

  std::vector<Node> nodes_;
  std::vector<std::uint32_t> leaf_of_;
  PointLanes lanes_;
};

// Returns the available points (one flag per point) within the gates of the model, ascending.
template <ShapeModel M>
std::vector<std::uint32_t> FindInliers(const M& model, const ModelPoints& points,
                                       const Octree& octree, const std::vector<char>& available,
                                       double gate_scale = 1) {
  std::vector<std::uint32_t> inliers;
  const auto ranges = octree.Reached(model, gate_scale * points.max_gate_m);
  for (const Hit& hit : octree.lanes().HitsIn(model, ranges, gate_scale)) {
    if (available[hit.at]) inliers.push_back(hit.at);
  }
  return inliers;
}

}  // namespace cwm::perception
