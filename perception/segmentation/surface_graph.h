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

// The largest difference in range, in metres, of linked pixels of one surface.
// chosen: 3 sigma of noise and 10 mm for the roughness of surfaces. (Cells of a grid are linked if
// they touch.)
inline float MaxJump_m(float sigma_m) { return 3 * sigma_m + 0.01f; }

class SurfaceGraph {
 public:
  // The graph of an organised cloud, with its points as nodes. `measured` must outlive the graph;
  // it may be rotated meanwhile, as links do not depend on the frame.
  static SurfaceGraph OfImage(const MeasuredPoints& measured, const Work& work);
  // The graph of any cloud, with the cells of the grid as nodes, as Downsample makes them. Both
  // must outlive the graph.
  static SurfaceGraph OfGrid(const OrientedPoints& nodes, const VoxelGrid& grid, const Work& work);

  const OrientedPoints& nodes() const { return *nodes_; }
  std::size_t size() const { return nodes_->size(); }
  float range_m(std::size_t node) const { return range_m_[node]; }
  // The number of measured points in a node (1 for pixels).
  std::uint32_t weight(std::size_t node) const { return grid_ ? grid_->moments(node).count : 1; }

  // Area of the surface that a node stands for, in square metres.
  double area_m2(std::size_t node) const;

  // The same surface for loops over the pixels of an image, and the image. Null for a grid.
  const SurfacePlanes* planes() const { return planes_.get(); }
  const MeasuredPoints* image() const { return measured_; }

  // Calls f(other) for the neighbours of this node on the same surface. Pixels are linked if they
  // differ by at most MaxJump_m in range and each is within 4 sigma or 1.5 pixels of the
  // other's tangent plane (if one is seen at a grazing angle, beyond kSteepIncidence_cos, one of
  // the two suffices). On slanted surfaces they may differ by three times as much in range if each
  // lies on the other's tangent plane.
  template <class F>
  void ForEachLinked(std::size_t node, F&& f) const;

  // True if a neighbour within MaxJump_m in range is not linked: the surface across the step
  // may be linked elsewhere by noise. False for a grid.
  bool IsAtStep(std::size_t node) const { return !at_step_.empty() && at_step_[node]; }

  // Calls f(other) for these neighbours. None for a grid.
  template <class F>
  void ForEachAcrossStep(std::size_t node, F&& f) const;

  // True if one of the eight neighbouring pixels is not linked. False for a grid.
  bool IsAtEdge(std::size_t node) const { return !beside_.empty() && beside_[node] != 0xff; }

  // Calls f(other) for the linked nodes that come before this one, so that each link occurs once.
  template <class F>
  void ForEachLinkedBefore(std::size_t node, F&& f) const;

  // Calls f(a, b) for pairs of nodes about the radius of a normal's neighbourhood away, on opposite
  // sides of this node, without a depth jump between them: their neighbourhoods touch but do not
  // overlap. In a grid they are searched at each call.
  template <class F>
  void ForEachOppositePair(std::size_t node, F&& f) const;

 private:
  // derived: a surface has 19 cells between two and three cells away from one of its cells, the
  // corner of a room three times as many. Cells with more fill space and have no creases.
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

  const MeasuredPoints* measured_ = nullptr;     // null for a grid
  std::shared_ptr<const SurfacePlanes> planes_;  // null for a grid
  const VoxelGrid* grid_ = nullptr;              // null for an image
  const OrientedPoints* nodes_ = nullptr;
  std::vector<float> range_m_;
  std::vector<std::uint8_t> beside_;  // image: bit k per node, linked to kNeighbourOffsets[k]
  std::vector<char> at_step_;         // image: per node
  std::array<std::ptrdiff_t, 8>
      step_to_{};  // image: index offset of neighbour kNeighbourOffsets[k]
  // Grid: the linked cells; those of a node are from its first_link_ to the next.
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
  // The first half of kNeighbourOffsets is the row above and the pixel to the left.
  constexpr unsigned kBefore = (1u << std::size(kNeighbourOffsets) / 2) - 1;
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
    const std::int32_t other =
        AtPixel(row + kNeighbourOffsets[k][0], column + kNeighbourOffsets[k][1]);
    if (other < 0) continue;
    const auto j = static_cast<std::size_t>(other);
    const float sigma_m = std::max(nodes_->sigma_m[node], nodes_->sigma_m[j]);
    if (std::abs(range_m_[node] - range_m_[j]) <= MaxJump_m(sigma_m)) f(j);
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
    const float slack = MaxJump_m(nodes_->sigma_m[node]);
    // On a slanted surface the range changes evenly on both sides; at a jump it does not.
    const float bend = range_m_[i] + range_m_[j] - 2 * range_m_[node];
    if (std::abs(bend) > slack) continue;
    if (std::abs(range_m_[i] - range_m_[j]) > 4 * slack) continue;
    f(i, j);
  }
}

}  // namespace cwm::perception
