// Which joints follow which.
#pragma once

#include <limits>
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

// How far the value of a joint that follows another may be from what that one makes of it, and beyond
// its own limits: fingers that mimic each other have encoders of their own, and files round multipliers
// and limits to three decimals.
inline constexpr double kFollowerTolerance = 1e-3;  // rad or m

// Values of a variable.
struct VariableRange {
  double lower = -std::numeric_limits<double>::infinity();
  double upper = std::numeric_limits<double>::infinity();
};

// The values of `source` at which the follower is within its own limits by kFollowerTolerance. Nothing
// where the two contradict each other: where the tolerance alone would let the source move, as when a
// sign is wrong or a <limit> tells nothing of positions.
std::optional<VariableRange> Narrowed(const VariableRange& source, const Following& following,
                                      const JointLimits& own);

}  // namespace cwm::collision
