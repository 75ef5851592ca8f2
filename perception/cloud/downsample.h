// The downsampled cloud P_d of the paper (section IV): one oriented point per cell of a grid.
#pragma once

#include "perception/cloud/oriented_points.h"
#include "perception/cloud/voxel_grid.h"

namespace cwm::perception {

// Returns one point per cell, in the order of the grid: the centroid, the mean normal (zero if the
// normals cancel), the mean noise, and the cloud index of the cell's first point. `grid` was built
// over `points`.
OrientedPoints Downsample(const OrientedPoints& points, const VoxelGrid& grid,
                          const Work& work = {});

}  // namespace cwm::perception
