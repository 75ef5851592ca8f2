// Equality of models, so that putting a model that the world already has has no effect.
#pragma once

#include "collision/geometry/hybrid_model.h"
#include "collision/world/world_robot.h"

namespace cwm::collision {

// True if all that readers can see is bitwise equal. Meshes are compared by content.
bool SameModel(const HybridModel& a, const HybridModel& b);

// True if no query can distinguish the robots: links, joints, variables, groups, self pairs,
// collision geometry, spheres and `left_out` are bitwise equal.
bool SameRobot(const RobotGeometry& a, const RobotGeometry& b);

// True if the poses are bitwise equal.
bool SamePose(const Pose& X_A, const Pose& X_B);

}  // namespace cwm::collision
