// The baseline: a plain tabletop pipeline as PCL's tutorials build it.
#pragma once

#include <vector>

#include "perception/cloud/point_cloud.h"

namespace cwm::benchmarks {

struct PclPlainTimes {
  double voxel_grid_ms = 0;
  double normals_ms = 0;
  double plane_ms = 0;
  double prism_ms = 0;
  double clusters_ms = 0;
  int clusters = 0;
  double total_ms() const { return voxel_grid_ms + normals_ms + plane_ms + prism_ms + clusters_ms; }
};

// Voxel grid of 4 mm, normals of 20 neighbours, SACMODEL_NORMAL_PLANE by RANSAC (1 000 iterations,
// probability 0.99, 10 mm, normal weight 0.1), prism over the convex hull of the plane (10 mm to
// 0.5 m), Euclidean clusters at 15 mm of 50 points or more. No models, no meshes, no world.
PclPlainTimes RunPclPlain(const perception::PointCloud& cloud);

}  // namespace cwm::benchmarks
