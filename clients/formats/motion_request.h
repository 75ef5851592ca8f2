// A request to plan a motion, as MoveIt and MotionBenchMaker write it in YAML
// (moveit_msgs/MotionPlanRequest).
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "clients/formats/scene_file.h"

namespace cwm::formats {

struct MotionRequest {
  std::string group;                     // empty: not said
  SceneRobotState start;                 // joints that it leaves out are where the robot has them
  std::vector<SceneJoint> goal;          // each joint once
  std::optional<double> allowed_time_s;  // > 0
  std::vector<std::string> warnings;     // what was left out, and why
};

// The one goal is of joints: other constraints of it, several goals, and constraints of the whole
// path are refused; tolerances, the workspace, planners and scaling are left out. Anything that
// does not fit is INVALID_ARGUMENT naming `file`, the field's path, its value and the rule.
absl::StatusOr<MotionRequest> ParseMotionRequest(std::string_view yaml, const std::string& file);

}  // namespace cwm::formats
