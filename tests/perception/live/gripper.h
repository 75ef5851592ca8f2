// A gripper on a gantry, simulated: a palm below a column, and two fingers that open along y.
#pragma once

#include <span>
#include <vector>

#include "perception/simulation/sequence_script.h"

namespace cwm::perception {

// Its place, turn and half opening at a time. The origin is between the fingers, 80 mm above their
// tips.
struct GripperPose {
  double time_s = 0;
  Vector3 p_W = Vector3::Zero();
  double yaw_rad = 0;
  double half_opening_m = 0.05;
};

inline constexpr std::size_t kPalm = 1;  // the link that moves the fingers

inline SimulatedRobot SimulateGripper(const std::vector<GripperPose>& path) {
  SimulatedRobot robot;
  robot.name = "gantry";
  robot.links.resize(4);
  robot.links[0].name = "base";
  robot.links[kPalm].name = "palm";
  robot.links[kPalm].parts = {
      {MakeTranslation(0, 0, 0.05), Box{{0.06, 0.2, 0.06}}},
      {MakeTranslation(0, 0, 0.23), Cylinder{.radius_m = 0.04, .length_m = 0.3}}};
  robot.links[2].name = "left_finger";
  robot.links[2].parts = {{MakeTranslation(0, 0.008, -0.03), Box{{0.02, 0.016, 0.10}}}};
  robot.links[3].name = "right_finger";
  robot.links[3].parts = {{MakeTranslation(0, -0.008, -0.03), Box{{0.02, 0.016, 0.10}}}};
  robot.variables = {"x", "y", "z", "yaw", "half_opening"};
  robot.link_poses = [](std::span<const double> q) -> std::vector<Pose> {
    const Pose X_WP =
        MakePose({q[0], q[1], q[2]}, Quaternion(Eigen::AngleAxisd(q[3], Vector3::UnitZ())));
    return {Pose::Identity(), X_WP, X_WP * MakeTranslation(0, q[4], 0),
            X_WP * MakeTranslation(0, -q[4], 0)};
  };
  for (const GripperPose& pose : path) {
    robot.trajectory.times_s.push_back(pose.time_s);
    robot.trajectory.rows.push_back(
        {pose.p_W.x(), pose.p_W.y(), pose.p_W.z(), pose.yaw_rad, pose.half_opening_m});
  }
  return robot;
}

}  // namespace cwm::perception
