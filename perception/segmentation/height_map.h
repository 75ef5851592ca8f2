// Heights of a support's nodes above its plane, on a raster in the plane.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "perception/segmentation/support_planes.h"
#include "perception/segmentation/surface_graph.h"

namespace cwm::perception {

// A rectangle of cells: [begin, end) in both directions.
struct CellRange {
  int begin_u = 0, end_u = 0, begin_v = 0, end_v = 0;
};

class HeightMap {
 public:
  // `nodes` must not be empty. Cells have about four nodes each.
  HeightMap(const SurfaceGraph& graph, const Plane& plane, const std::vector<std::uint32_t>& nodes);

  struct Cell {
    float points = 0;       // measured points in it
    float sum_m = 0;        // of their heights
    float variance_m2 = 0;  // sum of the variances of single heights
    bool has_data() const { return points > 0; }
    float height_m() const { return sum_m / points; }
  };

  int width() const { return width_; }
  int height() const { return height_; }
  double edge_m() const { return edge_m_; }
  std::size_t size() const { return cells_.size(); }
  const Cell& At(std::size_t i) const { return cells_[i]; }
  std::size_t IndexAt(int u, int v) const {
    return static_cast<std::size_t>(v) * static_cast<std::size_t>(width_) +
           static_cast<std::size_t>(u);
  }
  int u(std::size_t i) const { return static_cast<int>(i) % width_; }
  int v(std::size_t i) const { return static_cast<int>(i) / width_; }
  // The cell under a point; empty outside of the raster.
  std::optional<std::size_t> CellUnder(const Eigen::Vector3f& point) const;
  // The cell of nodes[k].
  std::size_t CellOfNode(std::size_t k) const { return cell_of_node_[k]; }
  // The number of cells in a length, at least 1.
  int CellsIn(double length_m) const;

  struct MeanHeights {
    std::vector<float> height_m;
    std::vector<float> sigma_m;  // of the mean
    float sigma_scale = 1;       // of all sigmas, where heights show more noise than is told
  };
  // Means over the points within `reach` cells of each cell with data; 0 elsewhere. Of
  // `points_per_sample` points one error is independent.
  MeanHeights Smoothed(int reach, double points_per_sample) const;
  // The height of the support around each cell: what most of a window of kLevelWindow_m has.
  std::vector<float> Level() const;

 private:
  std::vector<Cell> cells_;
  std::vector<std::size_t> cell_of_node_;
  Eigen::Matrix<double, 3, 2> across_;  // the axes of the raster
  Vector2 corner_m_ = Vector2::Zero();
  int width_ = 0, height_ = 0;
  double edge_m_ = 0;
};

// chosen: wider than things that are hardly higher than noise, narrower than most tables.
inline constexpr double kLevelWindow_m = 0.5;

}  // namespace cwm::perception
