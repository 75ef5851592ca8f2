// The joints between a robot's root and a tool, prepared for inverse kinematics.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "absl/status/statusor.h"
#include "collision/geometry/pose.h"
#include "collision/robot/robot_model.h"

namespace cwm::collision {

// chosen: more than the arms of any robot have; the normal equations are solved on the stack.
inline constexpr std::size_t kMaxIkVariables = 16;
inline constexpr std::size_t kMaxIkJoints = 32;

// A joint that moves with a variable of the chain, about or along the z axis of its frame.
struct IkJoint {
  bool slides = false;
  int variable = 0;  // of the chain
  // The joint's value is multiplier * (value of the variable) + offset.
  double multiplier = 1;
  double offset = 0;
  Pose X_PJ = Pose::Identity();  // the joint's frame in that of the previous joint, or the root's
};

// A variable of the chain, rad or m.
struct IkVariable {
  int of_group = 0;  // index into a row of the group
  double lower = 0;  // infinite if there are no limits
  double upper = 0;
  bool turns_endlessly = false;  // without limits, all its joints turn
};

struct IkChain {
  std::vector<IkJoint> joints;  // from the root to the tool
  std::vector<IkVariable> variables;
  Pose X_JT = Pose::Identity();  // the tool in the frame of the last joint

  // Numbers of one kind for the solver: row-major 3 x 4 per joint, then that of the tool.
  std::vector<double> numbers;
  std::vector<float> rounded_numbers;
};

// The chain that moves the tool, at X_LT in the frame of a link, by the variables of the group. The
// other variables have the values of `base`, one per variable of the model. INVALID_ARGUMENT if the
// group does not move the link, or moves it by a planar or floating joint or by more joints than
// the limits above.
absl::StatusOr<IkChain> MakeIkChain(const RobotModel& model, const JointGroup& group,
                                    std::span<const double> base, int link, const Pose& X_LT);

}  // namespace cwm::collision
