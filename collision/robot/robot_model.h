// A robot compiled for questions: links, variables, groups and self pairs as indices into arrays.
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

// A link with the joint that it hangs on. Indices are into RobotModel::links.
struct ModelLink {
  std::string name;
  int urdf_index = 0;  // the earlier link in the URDF has the lesser one
  int parent = 0;      // less than the link's own index; of the root: 0, itself
  // Links of one body never move against each other: only fixed joints are between them. The body
  // is named by its first link.
  int body = 0;
  std::string joint;  // empty for the root
  JointKind kind = JointKind::kFixed;
  Pose X_PJ = Pose::Identity();
  Vector3 axis_J = Vector3::UnitX();
  // Of a joint that is not fixed: its first variable, or that of the joint that it follows. The
  // value of a joint that follows is multiplier * variable + offset.
  int variable = 0;
  bool follows = false;
  double multiplier = 1;
  double offset = 0;
  std::vector<CollisionGeometry> collisions;
};

// One number of a state of the robot.
struct Variable {
  // The joint's name; of a joint with several: "JOINT/x", "/y", "/theta", or "/trans_x", "_y",
  // "_z", "/rot_x", "_y", "_z", "_w", as MoveIt calls them.
  std::string name;
  int link = 0;  // the one that the joint carries
  int component = 0;
  // Infinite where nothing sets any. Of the joint's own limits the part in which all that follows it
  // keeps its limits, too (Narrowed in mimic.h). The quaternion of a floating joint has limits of its
  // own, see OutOfLimits.
  double lower = 0;
  double upper = 0;
};

// Values for some of the variables, ascending; for none where all that the SRDF says was left out.
struct NamedState {
  std::string name;
  std::vector<int> variables;
  std::vector<double> values;
};

// Part of the variables, in the order of the model. A row of a question holds its variables alone.
struct JointGroup {
  std::string name;
  std::vector<int> variables;
  std::vector<std::string> joints;  // those with variables, in the same order
  // The links that the variables move, ascending: all that hang on a joint of the group or on one
  // that follows such a joint, whether or not the group has it.
  std::vector<int> moved_links;
  std::vector<NamedState> states;
};

// Two links by index, in the order of the URDF.
struct LinkPair {
  int first = 0;
  int second = 0;
  friend bool operator==(const LinkPair&, const LinkPair&) = default;
};

// Immutable once made. Every link comes after its parent, links[0] is the root; a URDF that lists
// parents first keeps its order. Variables are in the order of the links whose joints have them:
// fixed joints have none, nor those that follow another.
struct RobotModel {
  std::string name;
  std::vector<ModelLink> links;
  std::vector<Variable> variables;
  std::vector<JointGroup> groups;  // in the order of the SRDF
  JointGroup all;                  // every variable; without a name
  // The pairs of links that a question about the robot itself looks at, ordered by their place in
  // the URDF. Both have collision geometry, and they are not of one body. With an SRDF, those that
  // it disables are left out, and no others; without one, a link and the next above it that has
  // geometry are: such neighbours touch at their joint.
  std::vector<LinkPair> self_pairs;
  // Of the SRDF, as SemanticDescription has it, and of its states what MakeNamedState leaves out.
  std::vector<std::string> left_out;
  // Joints that follow others: whose limits narrow those of the variable, and whose limits contradict
  // them, which are not kept. A user should know of both.
  std::vector<std::string> narrowing, contradicting;

  // By name; nothing where there is none.
  std::optional<int> FindLink(std::string_view name) const;
  // The link that the joint carries.
  std::optional<int> FindJoint(std::string_view name) const;
  const JointGroup* FindGroup(std::string_view name) const;

  // By name, for the three above.
  std::map<std::string, int, std::less<>> link_index;
  std::map<std::string, int, std::less<>> joint_index;
  std::map<std::string, int, std::less<>> group_index;
};

// `semantic` may be null. Refuses what ReadUrdf and ReadSrdf refuse of trees, reaches, mimics and names,
// for descriptions that come from elsewhere.
absl::StatusOr<std::shared_ptr<const RobotModel>> MakeRobotModel(
    RobotDescription description, const SemanticDescription* semantic);

}  // namespace cwm::collision
