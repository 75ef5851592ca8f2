// cwm solve
#include <memory>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "clients/cli/commands.h"
#include "clients/cli/enum_names.h"
#include "clients/cli/exit_code.h"
#include "clients/cli/number_list.h"
#include "clients/cli/pose_argument.h"
#include "clients/cli/quantity.h"
#include "clients/cli/query_arguments.h"
#include "clients/cli/robot_arguments.h"
#include "clients/cli/table.h"
#include "clients/cpp/row_bytes.h"

namespace cwm::cli {
namespace {

namespace pb = cwm::v1;

struct SolveArguments {
  RobotArguments robot;
  std::vector<std::string> at;
  std::string tool, tool_link, x_link_tool;
  int max_solutions = 1;
  bool avoid_collision = false, same_branch = false;
  double position_tolerance_m = 0, rotation_tolerance_rad = 0;
  QueryArguments query;
  bool exit_code = false;
};

// The request without poses.
absl::StatusOr<pb::SolvePosesRequest> RequestOf(Session& session, const SolveArguments& given) {
  if (given.robot.name.empty()) return UsageError("--robot is required");
  pb::SolvePosesRequest request;
  auto robot = ParseRobotSubject(session, given.robot, "--x-world-base");
  if (!robot.ok()) return robot.status();
  std::vector<double> seeds;
  for (const std::string& text : given.robot.joints) {
    const auto row = ParseJoints(session, text, *robot);
    if (!row.ok()) return row.status();
    seeds.insert(seeds.end(), row->begin(), row->end());
    robot->mutable_rows()->set_width(static_cast<int>(row->size()));
  }
  robot->mutable_rows()->set_scalar(pb::SCALAR_F64);
  robot->mutable_rows()->set_data(seeds.data(), seeds.size() * sizeof(double));
  *request.mutable_robot() = *std::move(robot);
  request.set_tool(given.tool);
  request.set_tool_link(given.tool_link);
  if (!given.x_link_tool.empty()) {
    auto tool = ParsePoseArgument(session, given.x_link_tool, "--x-link-tool");
    if (!tool.ok()) return tool.status();
    *request.mutable_x_link_tool() = PoseToProto(*tool);
  }
  request.set_max_solutions(given.max_solutions);
  request.set_avoid_collision(given.avoid_collision);
  request.set_same_branch(given.same_branch);
  request.set_position_tolerance_m(given.position_tolerance_m);
  request.set_rotation_tolerance_rad(given.rotation_tolerance_rad);
  return request;
}

std::string JointsText(const pb::PoseSolution& solution) {
  return absl::StrJoin(solution.joints(), " ", [](std::string* out, double value) {
    absl::StrAppend(out, FormatFixed(value, 4));
  });
}

void PrintSolutions(const pb::SolvePosesResponse& response, Session& session) {
  std::vector<TableRow> lines;
  for (int pose = 0; pose < response.rows_size(); ++pose) {
    const pb::SolvedPoseRow& row = response.rows(pose);
    for (const pb::PoseSolution& solution : row.solutions()) {
      lines.push_back({{absl::StrCat(pose), ShortName(row.status()), JointsText(solution),
                        FormatFixed(1000 * solution.position_error_m(), 6),
                        FormatFixed(solution.rotation_error_rad(), 9)}});
    }
    if (row.solutions().empty()) {
      lines.push_back({{absl::StrCat(pose), ShortName(row.status()), "", "", ""}});
    }
  }
  session.streams.out << "tool on " << response.tool_link() << "; joints "
                      << absl::StrJoin(response.variables(), " ") << "\n";
  PrintTable({{"POSE", Align::kRight},
              {"STATUS"},
              {"JOINTS rad or m"},
              {"OFF mm", Align::kRight},
              {"OFF rad", Align::kRight}},
             lines, session.table_style(), session.streams.out);
}

absl::Status Solve(Session& session, const SolveArguments& arguments) {
  const auto options = ParseQueryOptions(arguments.query);
  if (!options.ok()) return options.status();
  const auto request = RequestOf(session, arguments);
  if (!request.ok()) return request.status();
  if (arguments.at.empty()) return UsageError("--at is required: a pose of the tool in the world");
  std::vector<client::PoseRow> poses;
  for (const std::string& text : arguments.at) {
    const auto pose = ParsePoseArgument(session, text, "--at");
    if (!pose.ok()) return pose.status();
    poses.push_back(*pose);
  }
  const auto answer = EvaluateRows<pb::SolvePosesRequest, pb::SolvePosesResponse>(
      session, &pb::QueryService::Stub::SolvePoses, poses, *options,
      [&](const std::vector<client::PoseRow>& some, pb::SolvePosesRequest& asked) {
        asked.MergeFrom(*request);
        asked.mutable_x_world_tool()->set_scalar(pb::SCALAR_F64);
        asked.mutable_x_world_tool()->set_data(client::RowBytes(some));
      });
  if (!answer.ok()) return answer.status();
  if (arguments.exit_code) {
    for (const pb::SolvedPoseRow& row : answer->rows()) {
      if (row.status() != pb::POSE_STATUS_SOLVED) session.verdict_code = ExitCode::kNotFree;
    }
  }
  PrintResult(session, *answer, poses.size(), PrintSolutions, "pose");
  return absl::OkStatus();
}

}  // namespace

void AddSolveCommand(CommandLine& line) {
  const auto arguments = std::make_shared<SolveArguments>();
  CLI::App& command = AddCommand(
      line,
      {"solve",
       "inverse kinematics: joint values at which a robot's tool is at a pose",
       {"cwm solve --robot panda --group panda_arm --at 0.4,0,0.5,1,0,0,0",
        "cwm solve --robot panda --group panda_arm --at mug+0,0,0.2 --x-link-tool 0,0,0.1034 "
        "--avoid-collision",
        "cwm solve --robot panda --group panda_arm --tool grip --at 0.4,0,0.5,1,0,0,0",
        "cwm solve --robot panda --group panda_arm --joints ready --same-branch --at "
        "0.4,0,0.5,1,0,0,0"},
       "The search begins at --joints, by default where the robot is, and at values drawn within "
       "the limits. A\n"
       "pose that is not reached is shown with the nearest state that was met; it is not proven to "
       "be out of\n"
       "reach."},
      [arguments](Session& session) { return Solve(session, *arguments); });
  AddRobotOptions(command, arguments->robot);
  command
      .add_option("--x-world-base", arguments->robot.at,
                  "the robot's root link in the world (m); default: where it stands")
      ->type_name(kPoseArgumentForm);
  command.add_option("--at", arguments->at, "pose of the tool in the world (m); repeatable")
      ->type_name(kPoseArgumentForm);
  CLI::Option* const tool =
      command
          .add_option("--tool", arguments->tool,
                      "a tool that the robot was loaded with; default: that of the group")
          ->type_name("NAME");
  command
      .add_option("--tool-link", arguments->tool_link,
                  "the link that carries the tool; default: that of the group's end effector")
      ->excludes(tool);
  command.add_option("--x-link-tool", arguments->x_link_tool, "the tool in that link's frame (m)")
      ->type_name("X,Y,Z[,QX,QY,QZ,QW]")
      ->excludes(tool);
  command.add_option("--max-solutions", arguments->max_solutions, "of each pose; default: 1");
  command.add_flag("--avoid-collision", arguments->avoid_collision,
                   "only states that are free of collisions");
  command.add_flag("--same-branch", arguments->same_branch,
                   "searches from the seed alone, without jumps to other configurations");
  command.add_option("--position-tolerance", arguments->position_tolerance_m,
                     "largest error (m); default: 1e-6");
  command.add_option("--rotation-tolerance", arguments->rotation_tolerance_rad,
                     "largest error (rad); default: 1e-6");
  command.add_flag("--exit-code", arguments->exit_code, "11 if a pose is not solved");
  AddQueryOptions(command, arguments->query);
  AddMarginOption(command, arguments->query);
  AddPairRuleOptions(command, arguments->query);
}

}  // namespace cwm::cli
