// The pose of a moving sensor, corrected by the known surfaces that it sees.
#pragma once

#include "perception/live/depth_noise.h"
#include "perception/live/expected_view.h"
#include "perception/live/pose_sigma.h"
#include "perception/live/robot_mask.h"

namespace cwm::perception {

struct PoseEstimate {
  Pose X_WC = Pose::Identity();
  PoseSigma sigma = {};  // of what is left of the error
  // What is left as an error of depths, one standard deviation: less than `sigma` makes, since the
  // surfaces that are seen determine it.
  double depth_sigma_m = 0;
};

// The pose that explains the depths of the frame best: one step of Gauss and Newton from X_WC, the
// pose that the view was rendered for, by the distances of points from expected planes (Chen and
// Medioni 1992), projectively associated (Newcombe et al. 2011, "KinectFusion"), with Tukey's
// weights. The given pose counts as a measurement with its standard deviations, so that directions
// that no surface determines stay as given. A view of nothing known gives the given pose.
PoseEstimate EstimatePose(const ExpectedView& view, const Pose& X_WC, const DepthImage& image,
                          const RobotMask& robots, const DepthCamera& camera,
                          const DepthNoise& noise, const Pose& X_WC_given, const PoseSigma& given);

}  // namespace cwm::perception
