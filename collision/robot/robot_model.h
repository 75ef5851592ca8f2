// A robot compiled for queries: links, variables, groups and self pairs as indices into arrays.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "collision/robot/robot_description.h"
#include "collision/robot/srdf.h"

namespace cwm::collision {

// A link and the joint above it. Indices are into RobotModel::links.
struct ModelLink {
  std::string name;
  int urdf_index = 0;  // position in the URDF
  int parent = 0;      // less than the link's own index; 0 for the root
  // The first link of its rigid body. Links of one body never move relative to each other, because
  // only fixed joints connect them.
  int body = 0;
  std::string joint;  // empty for the root
  JointKind kind = JointKind::kFixed;
  Pose X_PJ = Pose::Identity();
  Vector3 axis_J = Vector3::UnitX();
  // For a joint that is not fixed: its first variable, or that of the joint that it mimics. The
  // value of a mimic joint is multiplier * variable + offset.
  int variable = 0;
  bool is_mimic = false;
  double multiplier = 1;
  double offset = 0;
  std::vector<CollisionGeometry> collisions;  // scaled
  // Extra margin against the world, but not against the robot itself.
  double padding_m = 0;
  double scale = 1;  // with which the collision geometry was multiplied about its own origin
};

// One number of a state of the robot.
struct Variable {
  // The joint's name. For a joint with several variables, MoveIt's names: "JOINT/x", "/y",
  // "/theta", or "/trans_x", "_y", "_z", "/rot_x", "_y", "_z", "_w".
  std::string name;
  int link = 0;  // the link below the joint
  int component = 0;
  // The joint's own limits, narrowed so that all joints that mimic it keep their limits
  // (NarrowRange in mimic.h); infinite if there are none. The length of a floating joint's
  // quaternion is limited by OutOfLimits.
  double lower = 0;
  double upper = 0;
};

// Values for some of the variables, in ascending order of index. Empty if everything in the SRDF's
// state was left out.
struct NamedState {
  std::string name;
  std::vector<int> variables;
  std::vector<double> values;
};

// A subset of the variables, in the order of the model. A row of a query has values for these
// variables only.
struct JointGroup {
  std::string name;
  std::vector<int> variables;
  std::vector<std::string> joints;  // the joints of these variables, in the same order
  // The links that the variables move, ascending: all links below a joint of the group, or below a
  // joint that mimics one of the group, whether or not it is in the group itself.
  std::vector<int> moved_links;
  std::vector<NamedState> states;
  // The link that carries the group's tool: the parent link of the end effector that the SRDF names
  // for the group, or whose parent link the group moves; else the only end of the links that it
  // moves. Empty if there are several.
  std::optional<int> tool_link = {};
};

// Two links by index, in the order of the URDF.
struct LinkPair {
  int first = 0;
  int second = 0;
  friend bool operator==(const LinkPair&, const LinkPair&) = default;
};

// A frame T in which a tool acts, fixed to a link.
struct RobotTool {
  std::string name;
  int link = 0;
  Pose X_LT = Pose::Identity();
  std::string group = {};  // that moves the tool and uses it by default; empty: none
};

// Immutable once made. Every link comes after its parent, and links[0] is the root; a URDF with
// parents first keeps its order. Variables are in the order of the links below their joints. Fixed
// joints and mimic joints have none.
struct RobotModel {
  std::string name;
  std::vector<ModelLink> links;
  std::vector<Variable> variables;
  std::vector<JointGroup> groups;  // in the order of the SRDF
  JointGroup all;                  // all variables; has no name
  std::vector<RobotTool> tools;    // as given with the robot
  // The pairs of links that self collision checks use, in the order of the URDF. Both links have
  // collision geometry and belong to different bodies. With an SRDF, only the pairs that it
  // disables are left out. Without one, each link and the next link above it with geometry are left
  // out, because such neighbours touch at their joint.
  std::vector<LinkPair> self_pairs;
  // The lines of RobotDescription::left_out and of SemanticDescription::left_out, and those for its
  // states that MakeNamedState leaves out.
  std::vector<std::string> left_out;
  // Mimic joints whose limits narrow those of their source's variable, and mimic joints whose
  // limits contradict those and are ignored. Users should know of both.
  std::vector<std::string> narrowing, contradicting;

  // These functions find an element by name; empty or nullptr if there is none.
  std::optional<int> FindLink(std::string_view name) const;
  // The link below the joint.
  std::optional<int> FindJoint(std::string_view name) const;
  const JointGroup* FindGroup(std::string_view name) const;
  const RobotTool* FindTool(std::string_view name) const;

  // Indices by name, for the first three functions above.
  std::map<std::string, int, std::less<>> link_index;
  std::map<std::string, int, std::less<>> joint_index;
  std::map<std::string, int, std::less<>> group_index;
};

// Compiles a robot. `semantic` may be null. Checks the tree, the reach, the mimics and the names as
// ReadUrdf and ReadSrdf do, for descriptions from other sources.
absl::StatusOr<std::shared_ptr<const RobotModel>> MakeRobotModel(
    RobotDescription description, const SemanticDescription* semantic);

}  // namespace cwm::collision
