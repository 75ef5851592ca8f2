// Planning scenes in the two formats that MoveIt and the tools around it read.
#pragma once

#include <string>

#include "absl/status/statusor.h"
#include "server/export/planning_scene.h"

namespace cwm::server {

// The text of PlanningScene::saveGeometryToStream with poses of objects (".scene"): objects alone.
// The only errors of both are those of `go_on`.
absl::StatusOr<std::string> FormatSceneText(const PlanningScene& scene,
                                            const GoOn& go_on = absl::OkStatus);

// moveit_msgs/PlanningScene in YAML, vectors as flow lists, the matrix as lists of truth values: as
// MotionBenchMaker writes it.
absl::StatusOr<std::string> FormatSceneYaml(const PlanningScene& scene,
                                            const GoOn& go_on = absl::OkStatus);

}  // namespace cwm::server
