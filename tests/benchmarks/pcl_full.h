// The baseline of the whole interpreter: the chain that PCL's users build for the same outputs.
#pragma once

#include "perception/cloud/point_cloud.h"

namespace cwm::benchmarks {

struct PclFullTimes {
  double segmentation_ms = 0;  // voxels, normals, plane, prism, clusters
  double models_ms = 0;
  double first_models_ms = 0;  // the share of models_ms that one model per cluster takes
  double meshes_ms = 0;
  int clusters = 0;
  int models = 0;

  double total_ms() const { return segmentation_ms + models_ms + meshes_ms; }
  double with_one_model_ms() const { return segmentation_ms + first_models_ms + meshes_ms; }
};

// On one thread: voxels of 3 mm, normals of 20 neighbours, the largest plane, the prism above it,
// Euclidean clusters of 15 mm in the prism and in all that is neither prism nor plane (no point is
// lost here either); in each cluster RANSAC of plane, cylinder, sphere and cone (1 000 iterations,
// probability 0.99, our distance and normal gates), the best one kept, and again on the points left
// until no model has 60 voxels (a box has three faces); moving least squares and greedy projection
// of the rest.
PclFullTimes RunPclFull(const perception::PointCloud& cloud);

}  // namespace cwm::benchmarks
