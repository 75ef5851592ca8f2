// What a server says about ways to take things: whether the gripper gets there, what its pads meet.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "clients/cpp/connection.h"
#include "clients/grasp/gripper.h"

namespace cwm::grasp {

struct Question {
  std::string world = {};
  std::string world_uid = {};  // empty: whichever has the name
  std::int64_t revision = 0;   // all is asked of this one
  Gripper gripper = {};
  double friction = 0.4;
  double approach_m = 0.10;    // the way that the open gripper comes, straight along z of G
  double clearance_m = 0.002;  // that it keeps on that way, from the target as well
};

struct Attempt {
  Eigen::Isometry3d X_WG = Eigen::Isometry3d::Identity();
  std::string target = {};  // the object to be taken; empty: whatever both pads meet first
};

// Where a flat pad meets the target first.
struct Contact {
  Eigen::Vector3d point_W = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal_W = Eigen::Vector3d::Zero();  // outward
  double angle_rad = 0;                                // of the normal against the closing line
  int part = 0;                                        // of the target
};

enum class Fault {
  kNone,
  kBlocked,  // something is in the way of the open gripper or of its closing fingers
  kMisses,   // a pad meets nothing, or something else than the target
  kSlips,    // a surface is tilted by more than friction holds
};

struct Assessment {
  Fault fault = Fault::kNone;
  std::string culprit = {};              // what blocks or is met; empty: unknown
  double clearance_m = 0;                // of the open gripper on its way, told up to 0.02 m
  std::string held = {};                 // the object between the pads
  std::array<Contact, 2> contacts = {};  // of the finger at -x, then of that at +x
  double width_m = 0;                    // between the pads once both have met something
  double off_centre_m = 0;               // how far the object is pushed until both have
};

// One assessment for each attempt. First whether the open gripper has room at the grasp, then its
// motions, certified, not sampled, then whether the closing fingers meet anything but the target, and
// rays from 15 places of each pad: that of the middle has to hit, and the first place that meets the
// target has to hold it within friction.
absl::StatusOr<std::vector<Assessment>> Assess(const client::Connection& connection,
                                               const Question& question,
                                               const std::vector<Attempt>& attempts);

}  // namespace cwm::grasp
