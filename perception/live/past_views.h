// Earlier frames of a moving sensor, which tell where space was free.
#pragma once

#include <deque>
#include <memory>

#include "perception/live/depth_noise.h"
#include "perception/live/frame_evidence.h"
#include "perception/live/pixel_rays.h"

namespace cwm::perception {

// Keeps frames of the last seconds. A place is free in a frame if the frame's rays around it all
// end behind it: what is there now has entered, and what no frame saw through may have been there
// all the time.
class PastViews {
 public:
  PastViews(const DepthCamera& camera, const DepthNoise& noise) : camera_(camera), noise_(noise) {}

  // True if a kept frame saw through the place of this point, by more than both frames' errors.
  // `sigma` is that of the pose of the point's frame.
  bool SawThrough(const Vector3& p_W, const PoseSigma& sigma) const;

  // Keeps the frame if it is time to.
  void Keep(std::shared_ptr<const DepthImage> image, const Pose& X_WC, const PoseSigma& sigma,
            Stamp stamp);
  void Forget() { views_.clear(); }
  bool empty() const { return views_.empty(); }

 private:
  struct View {
    std::shared_ptr<const DepthImage> image = {};
    Pose X_CW = Pose::Identity();
    PoseSigma sigma = {};
    Stamp stamp = {};
  };

  const DepthCamera camera_;
  const DepthNoise& noise_;
  std::deque<View> views_;  // the oldest first
};

}  // namespace cwm::perception
