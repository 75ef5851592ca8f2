// The goal of a plan as the pose of a tool, solved for joint values by the server.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "clients/cpp/row_bytes.h"
#include "clients/planner/joint_space.h"
#include "clients/planner/state_query.h"

namespace cwm::planner {

// As in SolveOptions; what is empty or 0 is the server's default.
struct PoseGoal {
  client::PoseRow x_world_tool = {};
  std::string tool, tool_link;
  std::optional<client::PoseRow> x_link_tool = {};
  double position_tolerance_m = 0, rotation_tolerance_rad = 0;
};

struct SolvedGoal {
  api::PoseStatus status = api::PoseStatus::kNotComputed;
  // SOLVED: free states in which the tool is at the pose, nearest to the start first. Else one: the
  // nearest state that was met, the one out of limits, or the one in collision.
  std::vector<Row> rows;
  double position_error_m = 0, rotation_error_rad = 0;  // of the first row
  std::string tool_link;
};

// Up to 16 states that are free with the options of the query. INVALID_ARGUMENT if a quaternion is
// not of unit length.
absl::StatusOr<SolvedGoal> SolveGoal(const StateQuery& query, const Row& start,
                                     const PoseGoal& goal);

}  // namespace cwm::planner
