// The virtual scanner: turns placed shapes into a cloud with ground truth per point, under a
// sensor's noise. Used by the demo, the tests and the benchmarks.
#pragma once

#include <cstdint>
#include <vector>

#include "perception/cloud/point_cloud.h"
#include "perception/cloud/sensor_noise.h"
#include "perception/simulation/scenes.h"
#include "perception/simulation/simulated_scene.h"

namespace cwm::perception {

struct SimulatedCloud {
  PointCloud cloud;  // organised, in C
  // Per point, an index into scene.objects; -1: no return or background.
  std::vector<std::int32_t> object;
  std::vector<std::int32_t> part;  // per point, the part of the object
};

struct ScanOptions {
  SensorNoise noise = {};
  bool noiseless = false;
  bool matches_windows = false;  // only kRealSense: errors as kMatchedWindows (sensor_errors.h)
  std::uint64_t seed = 1;
};

// If `noiseless`, the points are where the rays of the pixels hit the surfaces, to the precision of
// a float. Otherwise they have the sensor's errors (sensor_errors.h): axial errors along the ray,
// and lateral ones that displace the ray, so that edges are ragged and slanted surfaces noisier.
// There are also mixed pixels at depth edges (object -1: they are on none), random drop-outs (1.5
// %), and drop-outs that increase from 70 degrees of incidence to all pixels at 85. Surfaces deeper
// than 10 m and shiny ones give no return. The camera has at least one pixel and a positive focal
// length. The same seed gives the same bytes.
SimulatedCloud Scan(const SimulatedScene& scene, const PinholeCamera& camera,
                    const ScanOptions& options);

}  // namespace cwm::perception
