#include "clients/planner/pose_goal.h"

#include <cmath>

#include "absl/strings/str_cat.h"
#include "clients/cpp/call_error.h"
#include "clients/cpp/world_stream.h"

namespace cwm::planner {
namespace {

// chosen: an arm of six joints has up to 8 states at a pose, one of seven a continuum; more goals
// make more trees to connect to, but a plan seldom shorter.
constexpr int kMaxGoals = 16;
// chosen: that of the server.
constexpr double kUnitTolerance = 1e-3;

absl::Status CheckUnit(const char* name, const client::PoseRow& row) {
  const double length = Eigen::Vector4d(row[3], row[4], row[5], row[6]).norm();
  if (std::abs(length - 1) <= kUnitTolerance) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat(name, ": the quaternion has length ", length, ", must be 1"));
}

}  // namespace

absl::StatusOr<SolvedGoal> SolveGoal(const StateQuery& query, const Row& start,
                                     const PoseGoal& goal) {
  if (auto status = CheckUnit("x_world_tool", goal.x_world_tool); !status.ok()) return status;
  SolveOptions options{.tool = goal.tool,
                       .tool_link = goal.tool_link,
                       .seeds = start,
                       .max_solutions = kMaxGoals,
                       .position_tolerance_m = goal.position_tolerance_m,
                       .rotation_tolerance_rad = goal.rotation_tolerance_rad,
                       .avoid_collision = true,
                       .query = query.options};
  if (goal.x_link_tool) {
    if (auto status = CheckUnit("x_link_tool", *goal.x_link_tool); !status.ok()) return status;
    options.X_LT = client::ToIsometry(*goal.x_link_tool);
  }
  try {
    const PoseResult answer =
        query.world.Solve(query.robot, client::ToIsometry(goal.x_world_tool), options);
    if (!answer.complete() || answer.states.cols() == 0) {
      return absl::DataLossError("the server answered no row of 1");
    }
    SolvedGoal solved{.status = answer.status[0],
                      .rows = {},
                      .position_error_m = answer.position_error_m[0],
                      .rotation_error_rad = answer.rotation_error_rad[0],
                      .tool_link = answer.tool_link};
    for (const auto& state : answer.states.colwise()) {
      solved.rows.emplace_back(state.begin(), state.end());
    }
    return solved;
  } catch (const Error& error) {
    return client::StatusFromError(error);
  }
}

}  // namespace cwm::planner
