// The measured surface as a graph: nodes with position and normal, and which of them lie side by
// side on one surface. Pixels of an organised cloud, small cells of any other.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <vector>

#include "perception/cloud/measured_points.h"
#include "perception/cloud/oriented_points.h"
#include "perception/cloud/voxel_grid.h"
#include "perception/cloud/work.h"

namespace cwm::perception {

// Surfaces never link across a jump in range larger than this (perception noise plus the roughness
// of what is worth holding together).
inline float LargestJump_m(float sigma_m) { return 3 * sigma_m + 0.01f; }

class SurfaceGraph {
 public:
  // Of an organised cloud: nodes are its points. Both keep copies of nothing but indices;
  // `measured` must outlive the graph, and be in the frame in which the graph is asked.
  static SurfaceGraph OfImage(const MeasuredPoints& measured);
  // Of any cloud: nodes are the cells of the grid.
  static SurfaceGraph OfGrid(const OrientedPoints& points, const VoxelGrid& grid, const Work& work);

  const OrientedPoints& nodes() const { return *nodes_; }
  std::size_t size() const { return nodes_->size(); }
  float range_m(std::size_t node) const { return range_m_[node]; }
  // Measured points behind a node (1 for pixels).
  std::uint32_t weight(std::size_t node) const { return grid_ ? grid_->moments(node).count : 1; }

  // Of the surface that a node stands for, metres^2.
  double area_m2(std::size_t node) const;

  // f(other) for the nodes right beside this one on the same surface.
  template <class F>
  void ForEachLinked(std::size_t node, F&& f) const;

  // f(a, b) for pairs of nodes about one normal neighbourhood away on opposite sides of this one,
  // no depth jump between: their neighbourhoods touch, but do not overlap.
  template <class F>
  void ForEachOppositePair(std::size_t node, F&& f) const;

 private:
  // No depth jump between; or each lies on the other's tangent plane, as neighbouring pixels of a
  // surface seen at a grazing angle do.
  bool Linked(std::size_t a, std::size_t b) const {
    const float jump = std::abs(range_m_[a] - range_m_[b]);
    const float sigma = std::max(nodes_->sigma_m[a], nodes_->sigma_m[b]);
    if (jump <= LargestJump_m(sigma)) return true;
    if (jump > 3 * LargestJump_m(sigma)) return false;
    if (nodes_->normals[a].isZero() || nodes_->normals[b].isZero()) return false;
    const Eigen::Vector3f d = nodes_->points[b] - nodes_->points[a];
    return std::abs(nodes_->normals[a].dot(d)) <= 3 * sigma &&
           std::abs(nodes_->normals[b].dot(d)) <= 3 * sigma;
  }
  std::int32_t AtPixel(int row, int column) const;
  int Reach_px(std::size_t node) const;
  void LinkCells(const Work& work);

  const MeasuredPoints* measured_ = nullptr;  // of an image
  const VoxelGrid* grid_ = nullptr;           // of a grid
  const OrientedPoints* nodes_ = nullptr;
  std::shared_ptr<OrientedPoints> own_nodes_;  // of a grid
  std::vector<float> range_m_;
  // Of a grid: linked cells and opposite pairs, per node from first to the next first.
  std::vector<std::uint32_t> first_link_, links_, first_pair_;
  std::vector<std::array<std::uint32_t, 2>> pairs_;
};

template <class F>
void SurfaceGraph::ForEachLinked(std::size_t node, F&& f) const {
  if (grid_) {
    for (std::uint32_t k = first_link_[node]; k < first_link_[node + 1]; ++k) f(links_[k]);
    return;
  }
  const auto pixel = static_cast<int>(nodes_->cloud_index[node]);
  const int row = pixel / measured_->width, column = pixel % measured_->width;
  for (int v = row - 1; v <= row + 1; ++v) {
    for (int u = column - 1; u <= column + 1; ++u) {
      const std::int32_t other = AtPixel(v, u);
      if (other < 0 || static_cast<std::size_t>(other) == node) continue;
      if (Linked(node, static_cast<std::size_t>(other))) f(static_cast<std::size_t>(other));
    }
  }
}

template <class F>
void SurfaceGraph::ForEachOppositePair(std::size_t node, F&& f) const {
  if (grid_) {
    for (std::uint32_t k = first_pair_[node]; k < first_pair_[node + 1]; ++k) {
      f(pairs_[k][0], pairs_[k][1]);
    }
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
