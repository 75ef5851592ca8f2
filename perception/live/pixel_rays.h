// Points of pixels in the level frame L.
#pragma once

#include <Eigen/Core>

#include "collision/geometry/pose.h"
#include "perception/live/depth_image.h"

namespace cwm::perception {

// The directions of pixels' rays with depth 1, in the frame L (world's axes, origin at the sensor).
class PixelRays {
 public:
  PixelRays(const DepthCamera& camera, const Pose& X_WC) {
    const Pinhole& pinhole = camera.pinhole;
    const Eigen::Matrix3f R = X_WC.linear().cast<float>();
    per_u_ = R.col(0) / static_cast<float>(pinhole.focal_u_px);
    per_v_ = R.col(1) / static_cast<float>(pinhole.focal_v_px);
    at_center_ = R.col(2);
    center_u_ = static_cast<float>(pinhole.center_u_px);
    center_v_ = static_cast<float>(pinhole.center_v_px);
  }

  Eigen::Vector3f Direction(int u, int v) const {
    return at_center_ + (static_cast<float>(u) - center_u_) * per_u_ +
           (static_cast<float>(v) - center_v_) * per_v_;
  }
  Eigen::Vector3f Point(int u, int v, float depth_m) const { return depth_m * Direction(u, v); }

 private:
  Eigen::Vector3f per_u_, per_v_, at_center_;
  float center_u_ = 0, center_v_ = 0;
};

}  // namespace cwm::perception
