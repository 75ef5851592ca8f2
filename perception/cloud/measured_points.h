// The finite points of a cloud, ready for the scene interpreter.
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"
#include "perception/cloud/no_index.h"
#include "perception/cloud/oriented_points.h"
#include "perception/cloud/point_cloud.h"
#include "perception/cloud/sensor_noise.h"
#include "perception/cloud/work.h"

namespace cwm::perception {

struct MeasuredPoints {
  OrientedPoints oriented;  // the finite points in the cloud's order; frame C at first
  // For an organised cloud, the image of indices into `oriented`, row-major, kNoIndex where there
  // is no finite point; else empty.
  std::vector<std::int32_t> image;
  int width = 0;
  int height = 0;
  bool seen_from_origin = true;  // as the cloud's
  // Number of finite points beyond the sensor's range, which are left out: saturated pixels.
  std::size_t beyond_range = 0;
  float pixel_angle_rad = 0;  // median angle between rays of neighbouring pixels

  bool organised() const { return !image.empty(); }

  // The angle between the rays of pixels with independent errors.
  float sample_angle_rad() const { return pixel_angle_rad * std::sqrt(oriented.points_per_sample); }
};

// Checks the cloud and collects its finite points with their noise. A few points beyond the sensor's
// range, or kWidestMap_m for a list of points, are left out. Normals are those of the cloud
// where it has valid ones (made unit, not turned), else zero. A cloud that claims to be organised
// but whose rays do not run as in an image (shuffled points) is treated as not organised.
// InvalidArgument if the cloud's layout contradicts itself, no point is finite, or a finite
// coordinate lies beyond kMaxCoordinate_m. Throws Stopped when `work` is stopped.
absl::StatusOr<MeasuredPoints> CollectMeasured(const PointCloud& cloud, const SensorNoise& noise,
                                               const Work& work = {});

}  // namespace cwm::perception
