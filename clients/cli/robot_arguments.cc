#include "clients/cli/robot_arguments.h"

#include <algorithm>
#include <map>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "clients/cli/enum_names.h"
#include "clients/cli/exit_code.h"
#include "clients/cli/link_values.h"
#include "clients/cli/number_list.h"
#include "clients/cli/one_of.h"
#include "clients/cli/pose_argument.h"

namespace cwm::cli {
namespace {

namespace pb = cwm::v1;

absl::StatusOr<pb::Robot> FindRobot(Session& session, const std::string& name) {
  pb::ListRobotsRequest request;
  request.set_world(session.world);
  request.set_name(name);
  const client::Connection& connection = session.connection();
  auto found = connection.Call(&pb::RobotService::Stub::ListRobots, connection.robots(), request);
  if (!found.ok()) return found.status();
  if (found->robots().empty()) return absl::NotFoundError(absl::StrCat("no robot \"", name, "\""));
  return found->robots(0);
}

// The states of that name, in the group or in any group, and all names for the error.
struct NamedStates {
  std::vector<const pb::NamedState*> found;
  std::vector<std::string> groups;  // of `found`
  std::vector<std::string> known;
};

NamedStates FindStates(const pb::Robot& robot, const std::string& group_name,
                       const std::string& name) {
  NamedStates states;
  for (const pb::RobotGroup& group : robot.groups()) {
    if (!group_name.empty() && group.name() != group_name) continue;
    for (const pb::NamedState& state : group.states()) {
      states.known.push_back(state.name());
      if (state.name() != name) continue;
      states.found.push_back(&state);
      states.groups.push_back(group.name());
    }
  }
  return states;
}

absl::StatusOr<const pb::NamedState*> FindState(const pb::Robot& robot, const std::string& group,
                                                const std::string& name) {
  const NamedStates states = FindStates(robot, group, name);
  if (states.found.size() == 1) {
    if (!states.found.front()->values().empty()) return states.found.front();
    return UsageError(absl::StrCat("--joints: \"", name, "\" says nothing that joints of ",
                                   states.groups.front(),
                                   " can take: `cwm robot load` warns of what it leaves out"));
  }
  if (states.found.size() > 1) {
    return UsageError(absl::StrCat("--joints: \"", name, "\" is a state of ",
                                   absl::StrJoin(states.groups, " and "),
                                   ": say which with --group"));
  }
  return UsageError(
      absl::StrCat("--joints: \"", name, "\" must be numbers, one for each joint, or a named state",
                   states.known.empty() ? std::string(", of which there are none")
                                        : absl::StrCat(": ", absl::StrJoin(states.known, ", "))));
}

// True if the variable is in the group's rows.
bool IsOfGroup(const pb::RobotVariable& variable, const pb::Robot& robot,
               const std::string& group_name) {
  if (group_name.empty()) return true;
  return std::any_of(robot.groups().begin(), robot.groups().end(), [&](const pb::RobotGroup& g) {
    return g.name() == group_name &&
           std::find(g.joints().begin(), g.joints().end(), variable.joint()) != g.joints().end();
  });
}

absl::Status CheckGroup(const pb::Robot& robot, const std::string& name) {
  if (name.empty()) return absl::OkStatus();
  std::vector<std::string> known;
  for (const pb::RobotGroup& group : robot.groups()) known.push_back(group.name());
  if (std::find(known.begin(), known.end(), name) != known.end()) return absl::OkStatus();
  return absl::NotFoundError(
      absl::StrCat("no group \"", name, "\" of \"", robot.name(),
                   "\": ", known.empty() ? "its SRDF has none" : absl::StrJoin(known, ", ")));
}

}  // namespace

void AddRobotOptions(CLI::App& command, RobotArguments& robot) {
  command.add_option("--robot", robot.name, "a robot of the world")->type_name("NAME");
  command
      .add_option("--group", robot.group,
                  "the joints that --joints gives; default: all of the robot's")
      ->type_name("NAME");
  command
      .add_option(
          "--joints", robot.joints,
          "its state (rad, m; --joints=-1,... where it begins with a minus), or one that the SRDF "
          "names; default: as it stands; may be repeated; \"-\": JSON lines on stdin")
      ->allow_extra_args(false)
      ->type_name("V,V,...|STATE");
  command
      .add_option(
          "--padding", robot.paddings,
          "the link's margin against the world, in place of that of its load (m; '*': of all "
          "others); repeatable")
      ->allow_extra_args(false)
      ->type_name(kPaddingForm);
  command.add_option("--scope", robot.scope, "against what: both (default), world or self")
      ->transform(OneOf(ShortNames<pb::RobotScope>()))
      ->type_name("SCOPE");
  command
      .add_option("--geometry", robot.geometry,
                  "of the robot: exact (default), spheres_as_given or spheres_containing")
      ->transform(OneOf(ShortNames<pb::RobotGeometry>()))
      ->type_name("GEOMETRY");
}

bool HasRobotOptions(const RobotArguments& robot) {
  return !robot.group.empty() || !robot.joints.empty() || !robot.paddings.empty() ||
         robot.scope != pb::ROBOT_SCOPE_UNSPECIFIED ||
         robot.geometry != pb::ROBOT_GEOMETRY_UNSPECIFIED;
}

absl::StatusOr<pb::RobotSubject> ParseRobotSubject(Session& session, const RobotArguments& robot,
                                                   const std::string& at_option) {
  pb::RobotSubject subject;
  subject.set_robot(robot.name);
  subject.set_group(robot.group);
  subject.set_scope(robot.scope);
  subject.set_robot_geometry(robot.geometry);
  for (const std::string& text : robot.paddings) {
    const auto padding = ParseLinkPadding(text);
    if (!padding.ok()) return padding.status();
    *subject.add_link_padding() = *padding;
  }
  if (robot.at.empty()) return subject;
  const auto pose = ParsePoseArgument(session, robot.at, at_option);
  if (!pose.ok()) return pose.status();
  *subject.mutable_x_world_base() = PoseToProto(*pose);
  return subject;
}

absl::StatusOr<std::vector<double>> ParseJoints(Session& session, const std::string& text,
                                                const pb::RobotSubject& subject) {
  if (StartsWithNumber(text)) return ParseNumbers(text, "--joints", "V,V,... (rad, m)");
  const auto robot = FindRobot(session, subject.robot());
  if (!robot.ok()) return robot.status();
  const auto state = FindState(*robot, subject.group(), text);
  if (!state.ok()) return state.status();
  std::map<std::string, double> named;
  for (const pb::VariableValue& value : (*state)->values()) {
    named[value.variable()] = value.value();
  }
  std::vector<double> row;
  for (int i = 0; i < robot->variables_size() && i < robot->state_size(); ++i) {
    const pb::RobotVariable& variable = robot->variables(i);
    if (!IsOfGroup(variable, *robot, subject.group())) continue;
    const auto value = named.find(variable.name());
    row.push_back(value != named.end() ? value->second : robot->state(i));
  }
  return row;
}

absl::StatusOr<pb::RobotJointState> ParseJointState(Session& session, const std::string& text,
                                                    const pb::RobotSubject& subject) {
  const auto robot = FindRobot(session, subject.robot());
  if (!robot.ok()) return robot.status();
  if (absl::Status known = CheckGroup(*robot, subject.group()); !known.ok()) return known;
  pb::RobotJointState joints;
  if (!StartsWithNumber(text)) {
    const auto state = FindState(*robot, subject.group(), text);
    if (!state.ok()) return state.status();
    *joints.mutable_values() = (*state)->values();
    return joints;
  }
  const auto numbers = ParseNumbers(text, "--joints", "V,V,... (rad, m)");
  if (!numbers.ok()) return numbers.status();
  std::vector<std::string> names;
  for (const pb::RobotVariable& variable : robot->variables()) {
    if (IsOfGroup(variable, *robot, subject.group())) names.push_back(variable.name());
  }
  if (numbers->size() != names.size()) {
    return UsageError(absl::StrCat("--joints has ", numbers->size(), " numbers, must be ",
                                   names.size(), ": ", absl::StrJoin(names, ", ")));
  }
  for (std::size_t k = 0; k < names.size(); ++k) {
    pb::VariableValue* value = joints.add_values();
    value->set_variable(names[k]);
    value->set_value((*numbers)[k]);
  }
  return joints;
}

}  // namespace cwm::cli
