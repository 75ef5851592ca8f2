// Which joints follow which.
#pragma once

#include <optional>
#include <vector>

#include "absl/status/statusor.h"
#include "collision/robot/robot_description.h"

namespace cwm::collision {

// The value of a joint is multiplier * (value of the source) + offset; the source follows nobody.
struct Following {
  int source = 0;  // joint, as an index into the description
  double multiplier = 1;
  double offset = 0;
};

// The greatest multiplier and offset: gears are far below, and no value of a joint overflows.
inline constexpr double kLargestMimic = 1e6;

// By joint; nothing for those that follow nobody. Chains are resolved to their end. Refuses
// followers of an unknown joint, of one without exactly one variable, of themselves in a cycle, and
// multipliers or offsets beyond kLargestMimic, their own or what a chain makes of them.
absl::StatusOr<std::vector<std::optional<Following>>> ResolveMimics(const RobotDescription& robot);

}  // namespace cwm::collision
