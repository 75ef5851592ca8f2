// Forward kinematics.
//
// The pose of a link C below its parent P is X_PC = X_PJ * motion(value). The motion is
// - for a revolute or continuous joint: the right-handed rotation by the value about axis_J;
// - for a prismatic joint: the translation by the value along axis_J;
// - for a planar joint (x, y, theta): the translation by x and y in the plane perpendicular to
//   axis_J, along the first two columns of BasisFromZ(axis_J) (x and y themselves if the axis is
//   z), followed by the rotation by theta about axis_J;
// - for a floating joint (tx ty tz qx qy qz qw): that pose. The quaternion is normalised; one of
//   length 0 is the identity.
// A state has one value for each of the model's variables. Values are not clamped.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "collision/geometry/pose.h"
#include "collision/robot/robot_model.h"

namespace cwm::collision {

// Computes the poses X_WL of all links in one pass, for a robot whose root is at X_WB. `X_WL` has
// one entry per link of the model, `variables` one per variable. Allocates nothing.
void LinkPoses(const RobotModel& model, const Pose& X_WB, std::span<const double> variables,
               std::span<Pose> X_WL);

// Computes LinkPoses for several states, stored one after the other in `states` and `X_WL`, several
// at a time in SIMD lanes. The number of states follows from the size of `X_WL`. The poses of a
// state depend on that state alone, and equal those of LinkPoses up to rounding.
void LinkPosesOfStates(const RobotModel& model, const Pose& X_WB, std::span<const double> states,
                       std::span<Pose> X_WL);

// Updates only the poses of the links that a group moves. `X_WL` holds the poses of a state that
// differs only in the group's variables, and receives those of the new state.
void MovedLinkPoses(const RobotModel& model, const JointGroup& group,
                    std::span<const double> variables, std::span<Pose> X_WL);

// The first variable whose value is outside its limits or not finite; empty if there is none.
// Values at the limits are inside, and so is any angle of a continuous joint without limits that no
// joint with limits mimics. The quaternion of a floating joint must have a length within 1 % of 1;
// otherwise its qx is returned. The limits of a mimic joint are part of the limits of its source's
// variable.
std::optional<int> OutOfLimits(const RobotModel& model, std::span<const double> variables);

// Each variable at 0, or in the middle of its limits if they exclude 0, as in MoveIt; floating
// joints at the identity rotation.
std::vector<double> DefaultVariables(const RobotModel& model);

}  // namespace cwm::collision
