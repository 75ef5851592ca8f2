// cwm robot load, list, get, set, remove
#include <memory>
#include <ostream>

#include "absl/strings/str_cat.h"
#include "clients/cli/all_pages.h"
#include "clients/cli/change_arguments.h"
#include "clients/cli/commands.h"
#include "clients/cli/exit_code.h"
#include "clients/cli/pose_argument.h"
#include "clients/cli/query_arguments.h"
#include "clients/cli/robot_arguments.h"
#include "clients/cli/robot_load_command.h"
#include "clients/cli/robot_table.h"

namespace cwm::cli {
namespace {

namespace pb = cwm::v1;

struct ShowArguments {
  std::string name;  // empty: all
  std::string at_revision;
};

struct SetArguments {
  RobotArguments robot;
  std::string joints;
  ChangeArguments change;
};

struct RemoveRobotArguments {
  std::string name;
  ChangeArguments change;
};

absl::StatusOr<pb::ListRobotsResponse> ListAll(Session& session, const ShowArguments& arguments) {
  pb::ListRobotsRequest request;
  request.set_world(session.world);
  request.set_name(arguments.name);
  const auto revision = ParseRevision(arguments.at_revision);
  if (!revision.ok()) return revision.status();
  *request.mutable_at_revision() = *revision;
  return ListAllPages<pb::ListRobotsResponse>(session, &pb::RobotService::Stub::ListRobots,
                                              session.connection().robots(), request);
}

absl::Status List(Session& session, const ShowArguments& arguments) {
  const auto response = ListAll(session, arguments);
  if (!response.ok()) return response.status();
  session.PrintList(
      *response,
      [&] {
        for (const pb::Robot& robot : response->robots()) session.PrintLine(robot);
      },
      [&] {
        PrintRobots(response->robots(), session.table_style(), session.streams.out);
        session.streams.out << "revision " << response->revision() << "\n";
      });
  return absl::OkStatus();
}

absl::Status Get(Session& session, const ShowArguments& arguments) {
  const auto response = ListAll(session, arguments);
  if (!response.ok()) return response.status();
  session.Print(*response, [&] {
    PrintRobotDetails(response->robots(0), session.table_style(), session.streams.out);
    session.streams.out << "revision " << response->revision() << "\n";
  });
  return absl::OkStatus();
}

absl::Status Set(Session& session, const SetArguments& arguments) {
  if (arguments.joints.empty() && arguments.robot.at.empty()) {
    return UsageError("--joints, --at or both");
  }
  const auto subject = ParseRobotSubject(session, arguments.robot, "--at");
  if (!subject.ok()) return subject.status();
  pb::Change change;
  pb::SetRobotState& state = *change.mutable_robot_state();
  state.set_name(arguments.robot.name);
  if (subject->has_x_world_base()) *state.mutable_x_world_base() = subject->x_world_base();
  if (!arguments.joints.empty()) {
    const auto joints = ParseJointState(session, arguments.joints, *subject);
    if (!joints.ok()) return joints.status();
    *state.mutable_joints() = *joints;
  }
  return Apply(session, arguments.change, {change}, absl::StrCat("set ", arguments.robot.name));
}

absl::Status Remove(Session& session, const RemoveRobotArguments& arguments) {
  pb::DeleteRobotRequest request;
  request.set_world(session.world);
  request.set_name(arguments.name);
  request.set_request_id(arguments.change.request_id);
  if (arguments.change.expected_revision) {
    request.set_expected_revision(*arguments.change.expected_revision);
  }
  const client::Connection& connection = session.connection();
  const auto response =
      connection.Call(&pb::RobotService::Stub::DeleteRobot, connection.robots(), request);
  if (!response.ok()) return response.status();
  session.Print(*response, [&] {
    session.streams.out << "removed " << arguments.name << ", revision " << response->revision()
                        << "\n";
  });
  return absl::OkStatus();
}

void AddListCommand(CommandLine& line, CLI::App& family) {
  const auto arguments = std::make_shared<ShowArguments>();
  CLI::App& command =
      AddCommand(line, family,
                 {"list",
                  "the robots of the world",
                  {"cwm robot list", "cwm robot list -o ndjson | jq -r .name"}},
                 [arguments](Session& session) { return List(session, *arguments); });
  AddRevisionOption(command, arguments->at_revision);
}

void AddGetCommand(CommandLine& line, CLI::App& family) {
  const auto arguments = std::make_shared<ShowArguments>();
  CLI::App& command =
      AddCommand(line, family,
                 {"get",
                  "one robot: links, variables with limits and values, groups and their states",
                  {"cwm robot get panda", "cwm robot get panda -o json"}},
                 [arguments](Session& session) { return Get(session, *arguments); });
  command.add_option("NAME", arguments->name, "of the robot")->required();
  AddRevisionOption(command, arguments->at_revision);
}

void AddSetCommand(CommandLine& line, CLI::App& family) {
  const auto arguments = std::make_shared<SetArguments>();
  CLI::App& command =
      AddCommand(line, family,
                 {"set",
                  "where a robot stands: its joints, its base; questions begin there",
                  {"cwm robot set panda --joints ready",
                   "cwm robot set panda --group hand --joints 0.04 --at 0,0.5,0"},
                  "What is not given stays. What is attached moves along."},
                 [arguments](Session& session) { return Set(session, *arguments); });
  command.add_option("NAME", arguments->robot.name, "of the robot")->required();
  command
      .add_option("--joints", arguments->joints,
                  "all of the group (rad, m; --joints=-1,... where it begins with a minus), or a "
                  "state that the SRDF names")
      ->type_name("V,V,...|STATE");
  command
      .add_option("--group", arguments->robot.group,
                  "the joints that --joints gives; default: all of the robot's")
      ->type_name("NAME");
  CLI::Option* const at =
      command.add_option("--at", arguments->robot.at, "its root link in the world (m)")
          ->type_name(kPoseArgumentForm);
  AddFormerName(command, "--x-world-base", arguments->robot.at, at);
  AddChangeOptions(command, arguments->change);
}

void AddRemoveCommand(CommandLine& line, CLI::App& family) {
  const auto arguments = std::make_shared<RemoveRobotArguments>();
  CLI::App& command =
      AddCommand(line, family, {"remove", "a robot", {"cwm robot remove panda"}},
                 [arguments](Session& session) { return Remove(session, *arguments); });
  command.add_option("NAME", arguments->name, "of the robot")->required();
  AddChangeOptions(command, arguments->change);
}

}  // namespace

void AddRobotCommands(CommandLine& line) {
  CLI::App& family =
      AddFamily(line, {"robot",
                       "robots of the world: load, list, get, set, remove",
                       {"cwm robot load panda.urdf --srdf panda.srdf", "cwm robot get panda"}});
  AddRobotLoadCommand(line, family);
  AddListCommand(line, family);
  AddGetCommand(line, family);
  AddSetCommand(line, family);
  AddRemoveCommand(line, family);
}

}  // namespace cwm::cli
