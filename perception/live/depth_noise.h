// The noise of a depth camera by depth, from a table.
#pragma once

#include <algorithm>
#include <vector>

#include "perception/cloud/sensor_noise.h"
#include "perception/live/depth_image.h"

namespace cwm::perception {

// chosen: a difference of this many standard deviations is not noise. derived: some 1 500 patches
// of correlated noise in an image, at 30 Hz for minutes, call for one false alarm in 10^8, and the
// spreads, which are measured in a few seconds, are only known within a quarter.
inline constexpr float kDifference_sigma = 5;

class DepthNoise {
 public:
  DepthNoise(const DepthCamera& camera, const SensorNoise& noise);

  // One standard deviation of the depth of a surface that faces the sensor, metres.
  float Axial_m(float depth_m) const { return At(depth_m).axial_m; }
  // One standard deviation of the place that a pixel shows, in pixels.
  float Lateral_px(float depth_m) const { return At(depth_m).lateral_px; }
  // The distance within which a known surface explains a depth, metres: ExplainedWithin_m, or
  // kDifference_sigma of noise and warp, and of an error of the sensor's pose while it moves.
  float Explained_m(float depth_m) const { return At(depth_m).explained_m; }
  float ExplainedWhileMoving_m(float depth_m) const { return At(depth_m).explained_moving_m; }
  // Sets the standard deviation of depths by the error of the pose of a sensor that moves.
  void SetPoseError(double sigma_m);

  const SensorNoise& model() const { return noise_; }

 private:
  struct Entry {
    float axial_m = 0, lateral_px = 0, explained_m = 0, explained_moving_m = 0;
  };

  const Entry& At(float depth_m) const {
    const float place = depth_m * per_m_;
    const auto last = static_cast<float>(table_.size() - 1);
    return table_[static_cast<std::size_t>(place > 0 ? std::min(place, last) : 0)];
  }

  SensorNoise noise_;
  double pose_error_m_ = -1;
  float per_m_ = 1;
  std::vector<Entry> table_;
};

}  // namespace cwm::perception
