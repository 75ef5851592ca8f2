// One frame of a depth camera, and the camera.
#pragma once

#include <cstddef>
#include <vector>

#include "perception/cloud/pinhole.h"

namespace cwm::perception {

struct DepthCamera {
  Pinhole pinhole;
  int width = 0;
  int height = 0;
  float least_range_m = 0.1F;  // nearer and farther depths are no return
  float greatest_range_m = 10;

  std::size_t pixel_count() const { return static_cast<std::size_t>(width) * height; }
  friend bool operator==(const DepthCamera&, const DepthCamera&) = default;
};

// Depths along the optical axis in metres, row-major; 0: no return. All others are finite and
// within the camera's range.
struct DepthImage {
  int width = 0;
  int height = 0;
  std::vector<float> depth_m;

  float at(int u, int v) const { return depth_m[static_cast<std::size_t>(v) * width + u]; }
};

}  // namespace cwm::perception
