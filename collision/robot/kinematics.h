// Where the links of a robot are.
//
// The pose of a link C below its parent P is X_PC = X_PJ * motion(value). The motion is
// - of a revolute or continuous joint the rotation by the value about axis_J, right-handed;
// - of a prismatic joint the translation by the value along axis_J;
// - of a planar joint (x, y, theta) the translation by x and y in the plane perpendicular to
//   axis_J, along the first two columns of BasisFromZ(axis_J) (x and y themselves where the axis is
//   z), and there the rotation by theta about axis_J;
// - of a floating joint (tx ty tz qx qy qz qw) that pose; the quaternion is normalised, and one
//   without a length turns nothing.
// A state is one value for each of the model's variables. Values are not clamped.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "collision/geometry/pose.h"
#include "collision/robot/robot_model.h"

namespace cwm::collision {

// The poses X_WL of all links in one sweep, for a robot whose root stands at X_WB. `X_WL` is as
// long as the links of the model, `variables` as its variables. Allocates nothing.
void LinkPoses(const RobotModel& model, const Pose& X_WB, std::span<const double> variables,
               std::span<Pose> X_WL);

// Of as many states as `X_WL` has room for, one after the other in both, several at a time in the
// machine's lanes. What is told of a state depends on that state alone; it is that of LinkPoses but for
// the last bits.
void LinkPosesOfStates(const RobotModel& model, const Pose& X_WB, std::span<const double> states,
                       std::span<Pose> X_WL);

// LinkPoses of the links that a group moves alone: `X_WL` holds the poses of a state that differs in
// variables of the group alone, and gets those of the new one.
void MovedLinkPoses(const RobotModel& model, const JointGroup& group,
                    std::span<const double> variables, std::span<Pose> X_WL);

// The first variable whose value is below its lower or above its upper limit or not a number. The
// limits themselves are inside, and any angle of a continuous joint that nothing with limits follows.
// The quaternion of a floating joint must have a length within 1 % of 1; its qx is named. A joint that
// follows leaves its limits where its source leaves those of its variable.
std::optional<int> OutOfLimits(const RobotModel& model, std::span<const double> variables);

// Each variable at 0, or in the middle of its limits where those exclude 0, as MoveIt has it;
// floating joints unturned.
std::vector<double> DefaultVariables(const RobotModel& model);

}  // namespace cwm::collision
