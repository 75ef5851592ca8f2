// Thins points to an even spacing, so that triangles between them are well shaped.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "perception/cloud/voxel_grid.h"

namespace cwm::perception {

// chosen: the least distance of two vertices, in edges of the grid; a cell's centroid may lie close
// to its border.
inline constexpr float kMinVertexGap = 0.6F;

struct ThinnedPoints {
  VoxelGrid grid;                            // over the points
  std::vector<Eigen::Vector3f> vertices;     // centroids of cells
  std::vector<std::int32_t> vertex_of_cell;  // the cell's centroid, or a vertex next to it
};

ThinnedPoints Thin(std::span<const Eigen::Vector3f> points, float spacing_m, const Work& work = {});

}  // namespace cwm::perception
