#include "clients/planner/plan_task.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "clients/cli/exit_code.h"
#include "clients/cli/number_list.h"
#include "clients/formats/file_bytes.h"
#include "clients/formats/motion_request.h"
#include "clients/scene/scene_robot.h"

namespace cwm::planner {
namespace {

using cli::UsageError;

// chosen: limits of files written by people and planners.
constexpr std::int64_t kMaxSceneBytes = 64 << 20, kMaxRequestBytes = 1 << 20;

absl::StatusOr<formats::MotionRequest> ReadRequest(const TaskArguments& arguments) {
  if (arguments.request.empty()) return formats::MotionRequest();
  const auto bytes = formats::ReadFileBytes(arguments.request, kMaxRequestBytes);
  if (!bytes.ok()) return bytes.status();
  return formats::ParseMotionRequest(*bytes, arguments.request);
}

absl::StatusOr<PlanningEnvironment> ReadEnvironment(const client::Connection& connection,
                                                    const TaskArguments& arguments,
                                                    const PlanningWorld& world) {
  if (arguments.problem.empty()) return EnvironmentOfWorld(world);
  const auto bytes = formats::ReadFileBytes(arguments.problem, kMaxSceneBytes);
  if (!bytes.ok()) return bytes.status();
  const auto scene = formats::ParseScene(*bytes, arguments.problem);
  if (!scene.ok()) return scene.status();
  return EnvironmentOfScene(connection, world, *scene);
}

absl::Status About(const std::string& what, const absl::Status& status) {
  return absl::Status(status.code(), absl::StrCat(what, ": ", std::string(status.message())));
}

// Parses --start or --goal.
absl::StatusOr<Row> ParseEndpoint(const std::string& option, const std::string& text,
                                  const v1::Robot& robot, const PlannedGroup& group) {
  if (!cli::StartsWithNumber(text)) {
    auto row = NamedState(robot, group, text);
    if (!row.ok())
      return UsageError(absl::StrCat(option, ": ", std::string(row.status().message())));
    return row;
  }
  return cli::ParseNumbers(text,
                           {option, absl::StrCat(group.joints.size(), " numbers, V,V,... (rad, m)"),
                            group.joints.size()});
}

}  // namespace

absl::StatusOr<Task> ReadTask(const client::Connection& connection, const TaskArguments& arguments,
                              std::vector<std::string>& warnings) {
  const auto request = ReadRequest(arguments);
  if (!request.ok()) return request.status();
  Task task;
  auto world = ReadPlanningWorld(connection, arguments.world, arguments.robot);
  if (!world.ok()) return world.status();
  task.world = *std::move(world);
  const auto environment = ReadEnvironment(connection, arguments, task.world);
  if (!environment.ok()) return environment.status();
  auto group = ReadPlannedGroup(environment->robot, arguments.group.value_or(request->group));
  if (!group.ok()) return group.status();
  task.group = *std::move(group);
  const scene::SceneState start =
      scene::ConvertRobotState(request->start, task.world.robot, "start_state");
  for (const auto* list : {&request->warnings, &environment->warnings, &start.warnings}) {
    warnings.insert(warnings.end(), list->begin(), list->end());
  }
  task.problem.joints = task.group.joints;
  task.problem.start = WithJoints(task.group, task.group.current, request->start.joints);
  if (!arguments.start.empty()) {
    auto row = ParseEndpoint("--start", arguments.start, environment->robot, task.group);
    if (!row.ok()) return row.status();
    task.problem.start = *std::move(row);
  }
  task.pose = arguments.pose;
  if (!task.pose) {
    auto goal = arguments.goal.empty()
                    ? RowOfAllJoints(task.group, request->goal)
                    : ParseEndpoint("--goal", arguments.goal, environment->robot, task.group);
    if (!goal.ok()) {
      return arguments.goal.empty()
                 ? About(absl::StrCat(arguments.request, ": goal_constraints[0].joint_constraints"),
                         goal.status())
                 : goal.status();
    }
    task.problem.goals = {*std::move(goal)};
  }
  auto query = MakeStateQuery(connection, task.world, *environment, task.group.name,
                              task.problem.joints, start.set);
  if (!query.ok()) return query.status();
  task.query = *std::move(query);
  task.options = arguments.options;
  if (request->allowed_time_s) task.options.time_limit_s = *request->allowed_time_s;
  if (arguments.time_s) task.options.time_limit_s = *arguments.time_s;
  return task;
}

}  // namespace cwm::planner
