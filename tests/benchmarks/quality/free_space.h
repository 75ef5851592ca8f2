// Nothing invented: rays that were seen to pass must not meet claimed geometry.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "perception/cloud/point_cloud.h"
#include "perception/cloud/sensor_noise.h"
#include "perception/simulation/simulated_scene.h"
#include "tests/benchmarks/quality/claimed_geometry.h"

namespace cwm::benchmarks {

struct FreeSpace {
  std::int64_t rays = 0;
  std::int64_t violating = 0;
  // The violating rays by the first claim met: deep inside a solid, or across a surface far from
  // all points.
  std::array<std::int64_t, kClaimCount> deep = {};
  std::array<std::int64_t, kClaimCount> crossed = {};

  double share() const { return rays == 0 ? 0 : static_cast<double>(violating) / rays; }
  void Add(const FreeSpace& other);
};

// Measurements besides the image whose rays are judged.
struct OtherMeasurements {
  std::vector<Eigen::Vector3f> points;  // of other views, in the camera's frame
  perception::SensorNoise noise = {};
  double before_sigma = 0;  // rays end as many sigmas before their hit, if that is more than 30 mm
};

// Measures the rays of every `stride`-th column and row of an organised cloud whose points lie on
// the rays of the camera's pixels. A ray from the sensor to 30 mm / cos(theta) before
// its hit violates if it runs more than 10 mm deep in any solid, or crosses a surface farther than
// max(10 mm, 3 sigma) from every measured point; theta is estimated from the neighbours of the hit.
FreeSpace MeasureFreeSpace(const ClaimedGeometry& claims, const perception::PointCloud& cloud,
                           const perception::PinholeCamera& camera, int stride,
                           const OtherMeasurements& other = {});

}  // namespace cwm::benchmarks
