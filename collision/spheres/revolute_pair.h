// Bounds the distance of two points that rotary joints move relative to each other. A pair of
// spheres that stays apart in every state need not be checked in any.
#pragma once

#include "collision/geometry/pose.h"

namespace cwm::collision {

// A joint that rotates a frame about the z axis of `X_PF`, given in the parent frame.
struct RevoluteJoint {
  Pose X_PF = Pose::Identity();
  double lower_rad = 0, upper_rad = 0;
};

// Points in a frame A and points in a frame B that is connected to A by two joints.
class RevolutePair {
 public:
  // `near` moves within its limits; `far`, which moves B, is assumed to turn all the way.
  RevolutePair(const RevoluteJoint& near, const RevoluteJoint& far);
  // For frames connected by a single joint.
  explicit RevolutePair(const RevoluteJoint& only) : RevolutePair({}, only) {}

  // True only if the points are farther apart than `distance_m` in every state. It may also be
  // false if they come within a millimetre of that distance.
  bool KeepsApart(const Vector3& p_A, const Vector3& p_B, double distance_m) const;

 private:
  double lower_rad_, upper_rad_;
  Pose X_NA_, X_FN_;  // from A to the near joint, and from there to the far one
};

}  // namespace cwm::collision
