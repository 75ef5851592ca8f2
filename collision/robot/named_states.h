// The states that an SRDF names, compiled for a robot.
#pragma once

#include "collision/robot/robot_model.h"
#include "collision/robot/srdf_groups.h"

namespace cwm::collision {

// What a state says of the variables of its group. The value of a joint that follows another counts
// where nothing is said of that one: it is then where the follower has that value. What cannot be
// taken, of joints outside of the group or of followers that what they follow puts elsewhere, goes to
// `left_out`. Every joint of the state must be one of the robot.
NamedState MakeNamedState(const SemanticState& semantic, const RobotModel& model,
                          const JointGroup& group, LeftOut& left_out);

}  // namespace cwm::collision
