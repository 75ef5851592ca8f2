// Reads a planning task from options and files.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "clients/cpp/connection.h"
#include "clients/planner/plan_motion.h"
#include "clients/planner/planned_group.h"
#include "clients/planner/planning_world.h"
#include "clients/planner/pose_goal.h"

namespace cwm::planner {

// The options as typed; empty: not given.
struct TaskArguments {
  std::string request, problem, robot, start, goal, world;
  std::optional<std::string> group;
  std::optional<PoseGoal> pose = {};  // in place of a goal
  std::optional<double> time_s;
  PlanOptions options = {};
};

struct Task {
  PlanningWorld world;
  PlannedGroup group;
  PlanProblem problem;           // without goals if there is a pose
  std::optional<PoseGoal> pose;  // to be solved for the goals
  std::optional<StateQuery> query;
  PlanOptions options;
};

// Options override the request. Adds what was ignored in the files, and why, to the warnings. An
// error in an option is a usage error (clients/cli/exit_code.h).
absl::StatusOr<Task> ReadTask(const client::Connection& connection, const TaskArguments& arguments,
                              std::vector<std::string>& warnings);

}  // namespace cwm::planner
