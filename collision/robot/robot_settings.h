// What a robot is loaded with besides its files: paddings and scales of links, tools.
#pragma once

#include <string>
#include <vector>

#include "collision/robot/link_values.h"
#include "collision/robot/robot_model.h"

namespace cwm::collision {

// A frame in which a tool acts, by the names of its link and group.
struct NamedTool {
  std::string name;
  std::string link;
  Pose X_LT = Pose::Identity();
  std::string group = {};  // empty: none
};

// What a robot is loaded with besides its files.
struct RobotSettings {
  LinkValues padding_m = {};
  LinkValues scale = {};  // given to ReadUrdf, which scales the geometry
  std::vector<NamedTool> tools = {};
};

// Sets the paddings, the scales as information, and the tools. Names that the model does not have
// are ignored: their reader refuses them.
void SetRobotSettings(const RobotSettings& settings, RobotModel& model);

}  // namespace cwm::collision
