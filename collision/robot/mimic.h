// Mimic joints, and the joints that they follow.
#pragma once

#include <limits>
#include <optional>
#include <vector>

#include "absl/status/statusor.h"
#include "collision/robot/robot_description.h"

namespace cwm::collision {

// The value of a joint is multiplier * (value of the source) + offset. The source does not follow
// another joint.
struct ResolvedMimic {
  int source = 0;  // joint, as an index into the description
  double multiplier = 1;
  double offset = 0;
};

// chosen: the largest magnitude of multiplier and offset. Real gears are far below, and the value
// of a joint cannot overflow.
inline constexpr double kMaxMimicCoefficient = 1e6;

// By joint; empty for joints that do not follow another. Chains are resolved to their end. Refuses
// joints that follow an unknown joint, a joint without exactly one variable, or themselves in a
// cycle; and multipliers or offsets beyond kMaxMimicCoefficient, in an element or for a whole
// chain.
absl::StatusOr<std::vector<std::optional<ResolvedMimic>>> ResolveMimics(
    const RobotDescription& robot);

// chosen: the allowed deviation of a mimic joint's value from the one computed from its source, and
// beyond its own limits. Fingers that mimic each other have encoders of their own, and files round
// multipliers and limits to three decimals.
inline constexpr double kMimicTolerance = 1e-3;  // rad or m

// The range of a variable.
struct VariableRange {
  double lower = -std::numeric_limits<double>::infinity();
  double upper = std::numeric_limits<double>::infinity();
};

// The values of `source` at which the mimic joint is within its own limits, up to
// kMimicTolerance. Empty if the ranges contradict each other, so that only the tolerance would
// let the source move: for instance if a sign is wrong, or a <limit> does not limit the position.
std::optional<VariableRange> NarrowRange(const VariableRange& source, const ResolvedMimic& resolved,
                                         const JointLimits& own);

}  // namespace cwm::collision
