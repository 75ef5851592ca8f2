// Reading an SRDF (MoveIt's, the ROS wiki's `srdf`): what a URDF does not say about a robot.
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

// Named joints of the robot, from the root outward: ordered by the links they carry, those in the
// order of MakeKinematicTree. Fixed joints and joints that follow others are among them.
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
  std::string reason;  // as the file says; often empty
};

struct EndEffector {
  std::string name;
  std::string group;
  std::string parent_link;
  std::string parent_group;  // may be empty
};

// How the robot stands in its surroundings. Kept as the file says: the pose of the base is an
// argument of every question, so that these joints have no variables.
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
  // Links of which no pair is checked (<disable_default_collisions>) but those that follow
  // (<enable_collisions>); `disabled_pairs` has the last word, as in MoveIt.
  std::vector<std::string> disabled_links;
  std::vector<NamedLinkPair> enabled_pairs;
  std::vector<EndEffector> end_effectors;
  std::vector<VirtualJoint> virtual_joints;
  std::vector<std::string> passive_joints;
  std::vector<std::string> left_out;  // a line for each element that names what there is not
};

// More lines than this are one that says how many.
inline constexpr std::size_t kMostLeftOut = 20;

// A group is the union of what its elements name: <joint> that joint, <link> the joint that the
// link hangs on, <chain> the joints on the way between its two links (through the link that both
// hang on, where neither hangs on the other), <group> all of another group, wherever in the file
// that is. Virtual joints are left out of groups and states; other elements are passed over, sphere
// approximations among them.
//
// Elements that name a link, a joint or a group that neither file has are left out with a line in
// `left_out`, as MoveIt does: an SRDF often outlives links of its URDF. Of groups and states that is
// the one member. A line likewise where the robot has another name than the URDF's, or nothing is
// said of groups and pairs.
//
// Refuses, with INVALID_ARGUMENT that names the element, the value and the rule: malformed XML,
// groups that hold themselves, group or state names that appear twice, positions with another number
// of values than the joint has (those of fixed joints are left out, as in MoveIt, with a line).
// RESOURCE_EXHAUSTED likewise for what RobotLimits excludes. CANCELLED soon after `stop` was requested.
absl::StatusOr<SemanticDescription> ReadSrdf(std::string_view xml, const RobotDescription& robot,
                                             const RobotLimits& limits = {},
                                             const std::stop_token& stop = {});

}  // namespace cwm::collision
