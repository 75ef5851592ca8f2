#include "clients/planner/planned_group.h"

#include <algorithm>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "clients/formats/format_error.h"

namespace cwm::planner {
namespace {

absl::StatusOr<Joint> ToJoint(const v1::RobotVariable& variable) {
  if (variable.joint_kind() == v1::JOINT_KIND_CONTINUOUS) {
    return Joint{.name = variable.name(), .kind = Joint::Kind::kContinuous};
  }
  const bool moves = variable.joint_kind() == v1::JOINT_KIND_REVOLUTE ||
                     variable.joint_kind() == v1::JOINT_KIND_PRISMATIC;
  if (moves && variable.has_lower() && variable.has_upper()) {
    return Joint{.name = variable.name(),
                 .kind = Joint::Kind::kLimited,
                 .lower = variable.lower(),
                 .upper = variable.upper()};
  }
  return absl::InvalidArgumentError(absl::StrCat(
      "joint ", variable.joint(), " is ", moves ? "without limits" : "planar or floating",
      ", must be revolute or prismatic with limits, or continuous: choose another "
      "--group"));
}

const v1::RobotGroup* FindGroup(const v1::Robot& robot, const std::string& name) {
  const auto found =
      std::find_if(robot.groups().begin(), robot.groups().end(),
                   [&](const v1::RobotGroup& group) { return group.name() == name; });
  return found == robot.groups().end() ? nullptr : &*found;
}

std::string JoinOr(const std::vector<std::string>& names, const char* none) {
  return names.empty() ? none : absl::StrJoin(names, ", ");
}

}  // namespace

absl::StatusOr<PlannedGroup> ReadPlannedGroup(const v1::Robot& robot, const std::string& name) {
  PlannedGroup group{.name = name, .joints = {}, .current = {}};
  const v1::RobotGroup* of_robot = FindGroup(robot, name);
  if (of_robot == nullptr && !name.empty()) {
    std::vector<std::string> names;
    for (const v1::RobotGroup& known : robot.groups()) names.push_back(known.name());
    return absl::InvalidArgumentError(absl::StrCat("group is \"", formats::Printable(name),
                                                   "\", must be one of ", robot.name(), ": ",
                                                   JoinOr(names, "it has none")));
  }
  for (int i = 0; i < robot.variables_size() && i < robot.state_size(); ++i) {
    const v1::RobotVariable& variable = robot.variables(i);
    if (of_robot != nullptr && std::find(of_robot->joints().begin(), of_robot->joints().end(),
                                         variable.joint()) == of_robot->joints().end()) {
      continue;
    }
    auto joint = ToJoint(variable);
    if (!joint.ok()) return joint.status();
    group.joints.push_back(*std::move(joint));
    group.current.push_back(robot.state(i));
  }
  if (group.joints.empty()) {
    return absl::InvalidArgumentError(absl::StrCat("group ", name, " has no joint that moves"));
  }
  return group;
}

absl::StatusOr<Row> NamedState(const v1::Robot& robot, const PlannedGroup& group,
                               const std::string& name) {
  std::vector<std::string> known, groups;
  std::vector<formats::SceneJoint> joints;
  for (const v1::RobotGroup& of_robot : robot.groups()) {
    if (!group.name.empty() && of_robot.name() != group.name) continue;
    for (const v1::NamedState& state : of_robot.states()) {
      known.push_back(state.name());
      if (state.name() != name) continue;
      groups.push_back(of_robot.name());
      for (const v1::VariableValue& value : state.values()) {
        joints.push_back({value.variable(), value.value()});
      }
    }
  }
  if (groups.size() == 1 && joints.empty()) {
    return absl::InvalidArgumentError(
        absl::StrCat("\"", name, "\" says nothing that joints of ", groups.front(), " can take"));
  }
  if (groups.size() == 1) return WithJoints(group, group.current, joints);
  if (groups.empty()) {
    return absl::InvalidArgumentError(
        absl::StrCat("\"", formats::Printable(name),
                     "\" must be numbers, one for each joint, or a named state: ",
                     JoinOr(known, "there is none")));
  }
  return absl::InvalidArgumentError(absl::StrCat(
      "\"", name, "\" is a state of ", absl::StrJoin(groups, " and "), ": say which with --group"));
}

Row WithJoints(const PlannedGroup& group, Row row, const std::vector<formats::SceneJoint>& joints) {
  for (std::size_t j = 0; j < group.joints.size(); ++j) {
    for (const formats::SceneJoint& joint : joints) {
      if (joint.name == group.joints[j].name) row[j] = joint.position;
    }
  }
  return row;
}

absl::StatusOr<Row> RowOfAllJoints(const PlannedGroup& group,
                                   const std::vector<formats::SceneJoint>& joints) {
  const auto named = [](const auto& list, const std::string& name) {
    return std::any_of(list.begin(), list.end(),
                       [&](const auto& entry) { return entry.name == name; });
  };
  for (const Joint& joint : group.joints) {
    if (named(joints, joint.name)) continue;
    return absl::InvalidArgumentError(
        absl::StrCat(joint.name, " is missing, every joint of the group must be there"));
  }
  for (const formats::SceneJoint& joint : joints) {
    if (named(group.joints, joint.name)) continue;
    return absl::InvalidArgumentError(
        absl::StrCat(formats::Printable(joint.name), " must be a joint of the group"));
  }
  return WithJoints(group, group.current, joints);
}

}  // namespace cwm::planner
