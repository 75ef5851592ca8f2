// Planning scenes in the two formats that MoveIt and the tools around it read.
#pragma once

#include <string>

#include "absl/status/statusor.h"
#include "server/export/planning_scene.h"

namespace cwm::server {

// The text of PlanningScene::saveGeometryToStream with object poses (".scene"): objects only. Both
// functions fail only with the status of `check_cancelled`.
absl::StatusOr<std::string> FormatSceneText(
    const PlanningScene& scene, const CancellationCheck& check_cancelled = absl::OkStatus);

// moveit_msgs/PlanningScene in YAML, vectors as flow lists, the matrix as lists of booleans, as
// MotionBenchMaker writes it.
absl::StatusOr<std::string> FormatSceneYaml(
    const PlanningScene& scene, const CancellationCheck& check_cancelled = absl::OkStatus);

}  // namespace cwm::server
