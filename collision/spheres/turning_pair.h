// Two points that joints turn about each other, and how near they may come: pairs of spheres that
// no state brings together need not be asked about in any.
#pragma once

#include "collision/geometry/pose.h"

namespace cwm::collision {

// Turns a frame about the z axis of `X_PF` in its parent's.
struct TurningJoint {
  Pose X_PF = Pose::Identity();
  double lower_rad = 0, upper_rad = 0;
};

// Of points of a frame A and of a frame B that hangs from A by two joints.
class TurningPair {
 public:
  // `near` moves within its limits; `far`, which moves B, is taken to turn all the way.
  TurningPair(const TurningJoint& near, const TurningJoint& far);
  // By one joint.
  explicit TurningPair(const TurningJoint& only) : TurningPair({}, only) {}

  // True only when the points are farther apart than the distance at every state; where they come
  // nearer than a millimetre more, it may be false as well.
  bool KeepsApart(const Vector3& p_A, const Vector3& p_B, double distance_m) const;

 private:
  double lower_rad_, upper_rad_;
  Pose X_NA_, X_FN_;  // from A to where the near joint turns, and from there to the far joint's
};

}  // namespace cwm::collision
