// Reads an SRDF (MoveIt's, the ROS wiki's `srdf`), which complements a URDF.
#pragma once

#include <optional>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "collision/robot/robot_description.h"
#include "collision/robot/robot_limits.h"

namespace cwm::collision {

// Named joints of the robot, from the root outward: in the order of the links below them, as in
// MakeKinematicTree. Includes fixed joints and mimic joints.
struct SemanticGroup {
  std::string name;
  std::vector<std::string> joints;
};

// The position of a joint: one value, or as many as the joint has variables (robot_model.h).
struct JointPosition {
  std::string joint;
  std::vector<double> values;
};

struct SemanticState {
  std::string name;
  std::string group;
  std::vector<JointPosition> positions;
};

struct NamedLinkPair {
  std::string link1;
  std::string link2;
  std::string reason;  // as in the file; often empty
};

struct EndEffector {
  std::string name;
  std::string group;
  std::string parent_link;
  std::string parent_group;  // may be empty
};

// The connection of the robot to its surroundings, as in the file. These joints have no variables,
// because the pose of the base is an argument of every query.
struct VirtualJoint {
  std::string name;
  std::string type;  // "fixed", "planar" or "floating"
  std::string parent_frame;
  std::string child_link;
};

struct SemanticDescription {
  std::vector<SemanticGroup> groups;
  std::vector<SemanticState> states;
  std::vector<NamedLinkPair> disabled_pairs;  // <disable_collisions>
  // `disabled_links` are links with no pair checked (<disable_default_collisions>) except those in
  // `enabled_pairs` (<enable_collisions>). `disabled_pairs` takes precedence over both, as in
  // MoveIt.
  std::vector<std::string> disabled_links;
  std::vector<NamedLinkPair> enabled_pairs;
  std::vector<EndEffector> end_effectors;
  std::vector<VirtualJoint> virtual_joints;
  std::vector<std::string> passive_joints;
  std::vector<std::string> left_out;  // one line for each element with an unknown name
};

// chosen: further lines are replaced by one that gives their number.
inline constexpr std::size_t kMaxLeftOut = 20;

// Reads an SRDF. A group is the union of its elements: <joint> is that joint; <link> is the joint
// above the link; <chain> is the joints on the path between its two links (through their common
// ancestor, if neither is above the other); <group> is all joints of another group, wherever in the
// file. Virtual joints are left out of groups and states. Other elements, such as sphere
// approximations, are ignored.
//
// Elements that refer to an unknown link, joint or group are left out with a line in `left_out`, as
// in MoveIt, because an SRDF often outlives links of its URDF. In groups and states this applies to
// the one member. There is also a line if the robot's name differs from the URDF's, or if the file
// has neither groups nor pairs.
//
// Refuses, with INVALID_ARGUMENT that names the element, the value and the rule: malformed XML,
// groups that contain themselves, duplicate names of groups or states, and positions with a wrong
// number of values (those of fixed joints are left out with a line, as in MoveIt).
// RESOURCE_EXHAUSTED for files that exceed RobotLimits. CANCELLED soon after `stop` was requested.
absl::StatusOr<SemanticDescription> ReadSrdf(std::string_view xml, const RobotDescription& robot,
                                             const RobotLimits& limits = {},
                                             const std::stop_token& stop = {});

}  // namespace cwm::collision
