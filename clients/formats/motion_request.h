// A motion planning request as MoveIt and MotionBenchMaker write it in YAML
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
  std::string group;                     // empty: not given
  SceneRobotState start;                 // missing joints keep the robot's values
  std::vector<SceneJoint> goal;          // each joint once
  std::optional<double> allowed_time_s;  // > 0
  std::vector<std::string> warnings;     // what was ignored, and why
};

// The goal must consist of joints only: other constraints, several goals and path constraints are
// refused; tolerances, the workspace, planners and scaling are ignored. Other errors are
// INVALID_ARGUMENT with `file`, the field's path, its value and the rule.
absl::StatusOr<MotionRequest> ParseMotionRequest(std::string_view yaml, const std::string& file);

}  // namespace cwm::formats
