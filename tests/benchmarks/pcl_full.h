// The rival of the whole interpreter: the chain that PCL's users build for the same outputs.
#pragma once

#include "perception/cloud/point_cloud.h"

namespace cwm::benchmarks {

struct PclFullTimes {
  double segmentation_ms = 0;  // voxels, normals, plane, prism, clusters
  double models_ms = 0;
  double meshes_ms = 0;
  int clusters = 0;
  int models = 0;

  double total_ms() const { return segmentation_ms + models_ms + meshes_ms; }
};

// On one thread: voxels of 3 mm, normals of 20 neighbours, the largest plane, the prism above it,
// Euclidean clusters of 15 mm; in each cluster RANSAC of plane, cylinder, sphere and cone (1 000
// iterations, probability 0.99, our distance and normal gates), the best one kept; greedy projection
// of what it leaves. One model a cluster is less than the same outputs: a box has three faces. Every
// second model more would make the chain slower, so the ratio is a lower bound.
PclFullTimes RunPclFull(const perception::PointCloud& cloud);

}  // namespace cwm::benchmarks
