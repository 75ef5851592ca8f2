// Pairs of links that their bounding spheres seldom prove apart.
#pragma once

#include <vector>

#include "collision/robot/robot_model.h"
#include "collision/robot/sphere_model.h"

namespace cwm::collision {

// The self pairs of the model whose spheres touch in at least kTightShare of some hundred states,
// which are drawn evenly within the limits. The same robot has the same pairs. None if the SIMD
// kinematics do not support a joint. Takes about a millisecond.
// chosen: the other pairs of a robot with two arms, some hundred, then leave most states free.
inline constexpr double kTightShare = 0.01;
std::vector<LinkPair> FindTightPairs(const RobotModel& model, const SphereModel& around);

}  // namespace cwm::collision
