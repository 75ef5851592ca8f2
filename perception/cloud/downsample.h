// The downsampled cloud P_d of the paper (section IV): one oriented point per cell of a grid.
#pragma once

#include "perception/cloud/oriented_points.h"
#include "perception/cloud/voxel_grid.h"

namespace cwm::perception {

// Per cell, in the order of the grid: centroid, mean normal (zero where they cancel), mean noise,
// and the cloud index of its first point. `grid` was built over `points`.
OrientedPoints Downsample(const OrientedPoints& points, const VoxelGrid& grid,
                          const Work& work = {});

}  // namespace cwm::perception
