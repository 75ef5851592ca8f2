// Planning scenes in the two formats that MoveIt and the tools around it read.
#pragma once

#include <string>

#include "server/export/planning_scene.h"

namespace cwm::server {

// The text of PlanningScene::saveGeometryToStream with poses of objects (".scene"): objects alone.
std::string FormatSceneText(const PlanningScene& scene);

// moveit_msgs/PlanningScene in YAML, vectors as flow lists, the matrix as lists of truth values: as
// MotionBenchMaker writes it.
std::string FormatSceneYaml(const PlanningScene& scene);

}  // namespace cwm::server
