// The virtual scanner: placed shapes in, a cloud with per-point ground truth out, under a sensor's
// noise. Serves the demo, the tests and the benchmarks.
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
  // Per point: index into scene.objects, -1 no return or background.
  std::vector<std::int32_t> object;
  std::vector<std::int32_t> part;  // per point: part of the object
};

struct ScanOptions {
  SensorNoise noise = {};
  bool noiseless = false;
  bool matches_windows = false;  // of kRealSense: errors as kMatchedWindows (sensor_errors.h)
  std::uint64_t seed = 1;
};

// `noiseless` returns where the rays of the pixels meet the surfaces, to the precision of a float.
// Otherwise the sensor's errors (sensor_errors.h): axial ones along the ray, lateral ones displace
// the ray, so that edges are ragged and slanted surfaces noisier. Besides: mixed pixels at depth
// edges (object -1: they lie on none), random drop-outs (1.5 %) and drop-outs from 70 degrees of
// incidence to none left at 85. Surfaces deeper than 10 m and shiny ones return nothing. The camera
// is at least one pixel large and its focal length positive. Same seed, same bytes.
SimulatedCloud Scan(const SimulatedScene& scene, const PinholeCamera& camera,
                    const ScanOptions& options);

}  // namespace cwm::perception
