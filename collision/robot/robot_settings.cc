#include "collision/robot/robot_settings.h"

#include <optional>

namespace cwm::collision {

void SetRobotSettings(const RobotSettings& settings, RobotModel& model) {
  for (ModelLink& link : model.links) {
    link.padding_m = ValueOf(settings.padding_m, link.name, 0);
    link.scale = ValueOf(settings.scale, link.name, 1);
  }
  for (const NamedTool& tool : settings.tools) {
    const std::optional<int> link = model.FindLink(tool.link);
    if (!link.has_value()) continue;
    model.tools.push_back(
        {.name = tool.name, .link = *link, .X_LT = tool.X_LT, .group = tool.group});
  }
}

}  // namespace cwm::collision
