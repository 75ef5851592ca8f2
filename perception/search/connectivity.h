// Connected components of an object's points (paper, section V: "we select the biggest connected
// component among the inlier candidates").
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "perception/cloud/voxel_grid.h"
#include "perception/search/model_points.h"

namespace cwm::perception {

// derived: a cell of this many spacings holds 9 points of an evenly sampled surface, so none is
// empty by chance.
inline constexpr double kSpacingsPerCell = 3;

// Points are connected if their cells touch (26 neighbours). Cells are at least three spacings and
// three standard deviations of the noise wide, so that a surface has no holes.
class Connectivity {
 public:
  explicit Connectivity(const ModelPoints& points);
  Connectivity(std::span<const Eigen::Vector3f> points, float edge_m);

  // Returns the components of the listed points, largest first; equal ones by their first point.
  // Each is in the order of the list.
  std::vector<std::vector<std::uint32_t>> Components(std::span<const std::uint32_t> listed) const;
  std::vector<std::uint32_t> LargestComponent(std::span<const std::uint32_t> listed) const;

  // Returns those of all points that lie in or beside a cell of a listed one.
  std::vector<std::uint32_t> Beside(std::span<const std::uint32_t> listed) const;

 private:
  void LinkCells();

  VoxelGrid grid_;
  std::vector<std::uint32_t> first_, neighbours_;  // neighbours of each cell, without itself
};

}  // namespace cwm::perception
