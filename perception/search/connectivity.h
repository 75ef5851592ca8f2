// Which points of an object hang together (paper, section V: "we select the biggest connected
// component among the inlier candidates").
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "perception/cloud/voxel_grid.h"
#include "perception/search/model_points.h"

namespace cwm::perception {

// derived: 9 points of an even surface lie in a cell of so many spacings, none is empty by chance.
inline constexpr double kSpacingsPerCell = 3;

// Points are connected when their cells touch (26 neighbours). Cells are three spacings or three
// standard deviations of the noise wide, so that a surface has no holes in it.
class Connectivity {
 public:
  explicit Connectivity(const ModelPoints& points);
  Connectivity(std::span<const Eigen::Vector3f> points, float edge_m);

  // The components of the listed points, largest first; equal ones by their first point. Each is in
  // the order of the list.
  std::vector<std::vector<std::uint32_t>> Components(std::span<const std::uint32_t> listed) const;
  std::vector<std::uint32_t> LargestComponent(std::span<const std::uint32_t> listed) const;

  // Of all points, those in or beside a cell of a listed one.
  std::vector<std::uint32_t> Beside(std::span<const std::uint32_t> listed) const;

 private:
  void LinkCells();

  VoxelGrid grid_;
  std::vector<std::uint32_t> first_, neighbours_;  // per cell, itself left out
};

}  // namespace cwm::perception
