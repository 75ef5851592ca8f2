// Compiles the named states of an SRDF for a robot.
#pragma once

#include "collision/robot/robot_model.h"
#include "collision/robot/srdf_groups.h"

namespace cwm::collision {

// The values that a state gives to the variables of its group. The value of a mimic joint
// determines that of its source if the state gives none for the source. Joints outside the group,
// and mimic joints whose value contradicts that of their source, are reported to `left_out` and
// ignored. Every joint of the state must be a joint of the robot.
NamedState MakeNamedState(const SemanticState& semantic, const RobotModel& model,
                          const JointGroup& group, SkippedElements& left_out);

}  // namespace cwm::collision
