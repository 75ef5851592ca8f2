// One step of the damped least squares search for joint values at which a chain reaches a pose, in
// single precision for several starts at once or in double precision for one.
//
// The step solves (J^T J + (alpha E + floor) 1) dq = J^T e (Sugihara, "Solvability-unconcerned
// inverse kinematics by the Levenberg-Marquardt method", 2011): e is the error of position, m, and
// kRotationWeight_m times that of rotation; E its squared length. Variables at a limit that the
// gradient points beyond are left out (projected Newton, Bertsekas 1982); no variable moves by more
// than 1 rad or m.
#pragma once

#include <cstddef>
#include <vector>

#include "collision/inverse_kinematics/ik_chain.h"

namespace cwm::collision {

inline constexpr std::size_t kIkStarts = 8;  // of one call in single precision
// chosen: a radian counts like the length of a hand and a forearm.
inline constexpr double kRotationWeight_m = 0.4;

// The pose of the tool in the root's frame, row-major 3 x 4.
template <class T>
struct IkTarget {
  T X_BT[12];
};
IkTarget<double> IkTargetOf(const Pose& X_BT);
IkTarget<float> RoundedIkTargetOf(const Pose& X_BT);

// The squared errors before a step: m^2, and 4 sin^2(angle / 2), which is the squared angle if that
// is small. In total position2 + kRotationWeight_m^2 rotation2.
template <class T, std::size_t kCount>
struct IkErrors {
  T position2[kCount];
  T rotation2[kCount];
  T Total(std::size_t k) const {
    constexpr T kWeight2 = static_cast<T>(kRotationWeight_m * kRotationWeight_m);
    return position2[k] + kWeight2 * rotation2[k];
  }
};

// Values of the chain's variables: value `variable` of start `k` is at [variable * kCount + k].
template <class T, std::size_t kCount>
struct IkValues {
  T of[kMaxIkVariables * kCount];
};

// Moves all starts by one step. Values stay within their limits if they are within them.
IkErrors<float, kIkStarts> StepIkStarts(const IkChain& chain, const IkTarget<float>& target,
                                        IkValues<float, kIkStarts>& values);
IkErrors<double, 1> StepIk(const IkChain& chain, const IkTarget<double>& target,
                           IkValues<double, 1>& values);

}  // namespace cwm::collision
