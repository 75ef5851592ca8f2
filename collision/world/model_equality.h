// When two models say the same, so that a put of what the world already holds has no effect.
#pragma once

#include "collision/geometry/hybrid_model.h"
#include "collision/world/world_robot.h"

namespace cwm::collision {

// Equal to the last bit in all that a reader can see. Meshes are compared by content.
bool SameModel(const HybridModel& a, const HybridModel& b);

// Two robots that no question can tell apart: links, joints, variables, groups, self pairs,
// collision geometry and spheres are equal to the last bit.
bool SameRobot(const RobotGeometry& a, const RobotGeometry& b);

// Bitwise equal poses.
bool SamePose(const Pose& X_A, const Pose& X_B);

}  // namespace cwm::collision
