// What the object modeler looks for, and how hard.
#pragma once

#include <cstdint>

namespace cwm::perception {

struct ModelerOptions {
  bool search_planes = true;
  bool search_cylinders = true;
  bool search_spheres = true;
  bool search_cones = true;
  double max_radius_m = 0.5;  // larger curved shapes are not told from planes at close range
  double min_radius_m = 0.004;
  int min_inliers = 60;                    // a shape must explain at least this many points
  double missed_shape_probability = 0.01;  // of a shape of min_inliers points
  std::uint64_t seed = 1;                  // same seed, same bytes
};

}  // namespace cwm::perception
