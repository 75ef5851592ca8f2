// The measured surface as a graph: nodes with position and normal, and which of them lie side by
// side on one surface. Pixels of an organised cloud, small cells of any other.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <memory>
#include <vector>

#include "perception/cloud/measured_points.h"
#include "perception/cloud/oriented_points.h"
#include "perception/cloud/voxel_grid.h"
#include "perception/cloud/work.h"
#include "perception/segmentation/surface_planes.h"

namespace cwm::perception {

// Surfaces of an image never link across a jump in range larger than this (perception noise plus
// the roughness of what is worth holding together); of a grid, cells that touch are linked.
inline float LargestJump_m(float sigma_m) { return 3 * sigma_m + 0.01f; }

class SurfaceGraph {
 public:
  // Of an organised cloud: nodes are its points. `measured` must outlive the graph, and may be
  // turned meanwhile: who is linked does not depend on the frame.
  static SurfaceGraph OfImage(const MeasuredPoints& measured, const Work& work);
  // Of any cloud: nodes are the cells of the grid, as Downsample makes them. Both must outlive the
  // graph.
  static SurfaceGraph OfGrid(const OrientedPoints& nodes, const VoxelGrid& grid, const Work& work);

  const OrientedPoints& nodes() const { return *nodes_; }
  std::size_t size() const { return nodes_->size(); }
  float range_m(std::size_t node) const { return range_m_[node]; }
  // Measured points behind a node (1 for pixels).
  std::uint32_t weight(std::size_t node) const { return grid_ ? grid_->moments(node).count : 1; }

  // Of the surface that a node stands for, metres^2.
  double area_m2(std::size_t node) const;

  // Of an image: the same surface for loops over its pixels, and their nodes. Null for a grid.
  const SurfacePlanes* planes() const { return planes_.get(); }
  const MeasuredPoints* image() const { return measured_; }

  // f(other) for the nodes right beside this one on the same surface. On an image: within
  // LargestJump_m in range and not off the other's tangent plane by more than 4 sigma or 1.5
  // pixels, neither of the two (where one is seen at a grazing angle, beyond kSteepIncidence_cos:
  // not both); or within three times that, as slanted surfaces are, and each on the other's tangent
  // plane.
  template <class F>
  void ForEachLinked(std::size_t node, F&& f) const;

  // Whether one right beside this node is not linked, though within LargestJump_m in range: what
  // lies across a step may be linked elsewhere by noise. False for a grid.
  bool IsAtStep(std::size_t node) const { return !at_step_.empty() && at_step_[node]; }

  // f(other) for them. For none of a grid.
  template <class F>
  void ForEachAcrossStep(std::size_t node, F&& f) const;

  // Whether one of the eight pixels right beside this one is not linked. False for a grid.
  bool IsAtEdge(std::size_t node) const { return !beside_.empty() && beside_[node] != 0xff; }

  // f(other) for those of them that come before this one in the order of nodes: each link once.
  template <class F>
  void ForEachLinkedBefore(std::size_t node, F&& f) const;

  // f(a, b) for pairs of nodes about one normal neighbourhood away on opposite sides of this one,
  // no depth jump between: their neighbourhoods touch, but do not overlap. Found anew in a grid.
  template <class F>
  void ForEachOppositePair(std::size_t node, F&& f) const;

 private:
  // derived: a surface has 19 cells between two and three cells away from one of its own, the
  // corner of a room three times as many. What has more fills space: nothing bends there.
  static constexpr std::size_t kMaxAround = 60;
  struct CellPairs {
    std::array<std::array<std::uint32_t, 2>, kMaxAround> pairs;
    std::size_t count = 0;
  };

  std::int32_t AtPixel(int row, int column) const;
  int Reach_px(std::size_t node) const;
  void LinkPixels(const Work& work);
  void LinkCells(const Work& work);
  CellPairs PairsOfCell(std::size_t cell) const;

  const MeasuredPoints* measured_ = nullptr;     // of an image
  std::shared_ptr<const SurfacePlanes> planes_;  // of an image
  const VoxelGrid* grid_ = nullptr;              // of a grid
  const OrientedPoints* nodes_ = nullptr;
  std::vector<float> range_m_;
  std::vector<std::uint8_t> beside_;         // of an image: bit k per node, linked to kBeside[k]
  std::vector<char> at_step_;                // of an image, per node
  std::array<std::ptrdiff_t, 8> step_to_{};  // of an image: pixels from a pixel to kBeside[k]
  // Of a grid: the linked cells, per node from first to the next first.
  std::vector<std::uint32_t> first_link_, links_;
};

template <class F>
void SurfaceGraph::ForEachLinked(std::size_t node, F&& f) const {
  if (grid_) {
    for (std::uint32_t k = first_link_[node]; k < first_link_[node + 1]; ++k) f(links_[k]);
    return;
  }
  const std::int32_t* const pixel = measured_->image.data() + nodes_->cloud_index[node];
  for (unsigned bits = beside_[node]; bits != 0; bits &= bits - 1) {
    f(static_cast<std::size_t>(pixel[step_to_[static_cast<std::size_t>(std::countr_zero(bits))]]));
  }
}

template <class F>
void SurfaceGraph::ForEachLinkedBefore(std::size_t node, F&& f) const {
  if (grid_) {
    ForEachLinked(node, [&](std::size_t other) {
      if (other < node) f(other);
    });
    return;
  }
  // The first half of kBeside: the row above, and the pixel to the left.
  constexpr unsigned kBefore = (1u << std::size(kBeside) / 2) - 1;
  const std::int32_t* const pixel = measured_->image.data() + nodes_->cloud_index[node];
  for (unsigned bits = beside_[node] & kBefore; bits != 0; bits &= bits - 1) {
    f(static_cast<std::size_t>(pixel[step_to_[static_cast<std::size_t>(std::countr_zero(bits))]]));
  }
}

template <class F>
void SurfaceGraph::ForEachAcrossStep(std::size_t node, F&& f) const {
  if (!IsAtStep(node)) return;
  const auto pixel = static_cast<int>(nodes_->cloud_index[node]);
  const int row = pixel / measured_->width, column = pixel % measured_->width;
  for (unsigned k = 0; k < 8; ++k) {
    if (beside_[node] >> k & 1) continue;
    const std::int32_t other = AtPixel(row + kBeside[k][0], column + kBeside[k][1]);
    if (other < 0) continue;
    const auto j = static_cast<std::size_t>(other);
    const float sigma_m = std::max(nodes_->sigma_m[node], nodes_->sigma_m[j]);
    if (std::abs(range_m_[node] - range_m_[j]) <= LargestJump_m(sigma_m)) f(j);
  }
}

template <class F>
void SurfaceGraph::ForEachOppositePair(std::size_t node, F&& f) const {
  if (grid_) {
    const CellPairs found = PairsOfCell(node);
    for (std::size_t k = 0; k < found.count; ++k) f(found.pairs[k][0], found.pairs[k][1]);
    return;
  }
  constexpr int kDirections[4][2] = {{0, 1}, {1, 0}, {1, 1}, {1, -1}};
  const auto pixel = static_cast<int>(nodes_->cloud_index[node]);
  const int row = pixel / measured_->width, column = pixel % measured_->width;
  const int reach = Reach_px(node);
  for (const auto& d : kDirections) {
    const int steps = d[0] != 0 && d[1] != 0 ? (reach * 7 + 5) / 10 : reach;  // 1 / sqrt(2)
    const std::int32_t a = AtPixel(row - steps * d[0], column - steps * d[1]);
    const std::int32_t b = AtPixel(row + steps * d[0], column + steps * d[1]);
    if (a < 0 || b < 0) continue;
    const auto i = static_cast<std::size_t>(a), j = static_cast<std::size_t>(b);
    const float slack = LargestJump_m(nodes_->sigma_m[node]);
    // A slanted surface changes in range over the reach, evenly on both sides; a jump does not.
    const float bend = range_m_[i] + range_m_[j] - 2 * range_m_[node];
    if (std::abs(bend) > slack) continue;
    if (std::abs(range_m_[i] - range_m_[j]) > 4 * slack) continue;
    f(i, j);
  }
}

}  // namespace cwm::perception
