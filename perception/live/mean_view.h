// The mean of some frames of a sensor that stands still.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "perception/live/frame_evidence.h"

namespace cwm::perception {

// A frame of a sensor that stands still, with the classes of its pixels.
struct StillFrame {
  std::shared_ptr<const DepthImage> image = {};
  std::shared_ptr<const FrameClasses> classes = {};
};

// The mean depths of things at rest, as a sensor measures them that stands still.
struct MeanView {
  std::string sensor = {};
  Pose X_WC = Pose::Identity();
  DepthCamera camera = {};
  SensorNoise noise = {};
  // Standard deviations of the given pose, for each component.
  double pose_sigma_m = 0.005;
  double pose_sigma_rad = 0.005;
  // The mean of some frames, row-major; 0: no return, not at rest, or of a robot.
  std::vector<float> depth_m = {};
};

// The mean depth of pixels that no frame gives to a robot, over the returns that agree with their
// median within noise: beside an edge a pixel shows what is before and what is behind in turn, and
// the mean of both is nowhere. Most of the first frames and most of the last ones have such
// returns, and are equally deep. At least two frames.
std::vector<float> MeanAtRest(std::span<const StillFrame> frames, const DepthCamera& camera,
                              const SensorNoise& noise);

}  // namespace cwm::perception
