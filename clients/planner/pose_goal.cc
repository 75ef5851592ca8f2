#include "clients/planner/pose_goal.h"

namespace cwm::planner {
namespace {

// chosen: an arm of six joints has up to 8 states at a pose, one of seven a continuum; more goals
// make more trees to connect to, but a plan seldom shorter.
constexpr int kMaxGoals = 16;

void SetPose(const client::PoseRow& row, v1::Pose& pose) {
  pose.set_tx_m(row[0]);
  pose.set_ty_m(row[1]);
  pose.set_tz_m(row[2]);
  pose.set_qx(row[3]);
  pose.set_qy(row[4]);
  pose.set_qz(row[5]);
  pose.set_qw(row[6]);
}

}  // namespace

absl::StatusOr<SolvedGoal> SolveGoal(client::QueryStream& stream,
                                     const v1::CheckCollisionsRequest& query, const Row& start,
                                     const PoseGoal& goal) {
  v1::StreamQueriesRequest stream_request;
  v1::SolvePosesRequest& request = *stream_request.mutable_solve_poses();
  request.set_world(query.world());
  *request.mutable_robot() = query.subject().robot();
  v1::JointRows& seed = *request.mutable_robot()->mutable_rows();
  seed.set_scalar(v1::SCALAR_F64);
  seed.set_width(static_cast<std::int32_t>(start.size()));
  seed.set_data(start.data(), start.size() * sizeof(double));
  request.set_tool(goal.tool);
  request.set_tool_link(goal.tool_link);
  if (goal.x_link_tool) SetPose(*goal.x_link_tool, *request.mutable_x_link_tool());
  request.mutable_x_world_tool()->set_scalar(v1::SCALAR_F64);
  request.mutable_x_world_tool()->set_data(
      client::RowBytes(std::vector<client::PoseRow>{goal.x_world_tool}));
  request.set_position_tolerance_m(goal.position_tolerance_m);
  request.set_rotation_tolerance_rad(goal.rotation_tolerance_rad);
  request.set_max_solutions(kMaxGoals);
  request.set_avoid_collision(true);
  *request.mutable_options() = query.options();
  request.mutable_options()->set_result_form(v1::RESULT_FORM_ROWS);
  const auto response = stream.Evaluate(stream_request);
  if (!response.ok()) return response.status();
  const v1::SolvePosesResponse& answer = response->solve_poses();
  if (answer.rows_size() != 1 || answer.rows(0).solutions().empty()) {
    return absl::DataLossError("the server answered no row of 1");
  }
  const v1::SolvedPoseRow& row = answer.rows(0);
  SolvedGoal solved{.status = row.status(),
                    .rows = {},
                    .position_error_m = row.solutions(0).position_error_m(),
                    .rotation_error_rad = row.solutions(0).rotation_error_rad(),
                    .tool_link = answer.tool_link()};
  for (const v1::PoseSolution& solution : row.solutions()) {
    solved.rows.emplace_back(solution.joints().begin(), solution.joints().end());
  }
  return solved;
}

}  // namespace cwm::planner
