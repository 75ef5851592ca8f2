// Pairs that have a formula. All answers are in the frame of A (of the first argument), A before B,
// with the witness points and the normal of PairDistance.
#pragma once

#include "collision/kernels/convex_core.h"
#include "collision/kernels/pair_answer.h"

namespace cwm::collision {

// A half-space as A and a bounded convex B. Exact, also as the least translation.
PairDistance HalfSpaceToConvex(const ConvexCore& b, const Pose& X_AB);

// Capsules by the nearest points of their segments.
PairDistance CapsuleToCapsule(const Capsule& a, const Capsule& b, const Pose& X_AB);

// The squared distance of a box to a point on a segment is a convex, piecewise quadratic function
// of the point's place: its least value is found by its pieces. Overlap by separating axes.
PairDistance BoxToCapsule(const Box& a, const Capsule& b, const Pose& X_AB);

// The least overlap over the 15 axes that can part two boxes (Gottschalk 1996): the least
// translation where they overlap. Where they do not, only a lower bound of their distance, and no
// witness points.
struct BoxOverlap {
  double depth_m;  // negative when an axis parts them
  Vector3 normal;  // unit, from A to B, in the frame of A
};
BoxOverlap LeastBoxOverlap(const Box& a, const Box& b, const Pose& X_AB);
// Whether its depth is positive: the first axis that parts the boxes ends the search.
bool BoxesOverlap(const Box& a, const Box& b, const Pose& X_AB);

// Cylinders, cones and capsules of which the axes are parallel: their difference is a solid of
// revolution again, with the sum of their profiles. Precondition: AxesAreParallel(X_AB).
bool AxesAreParallel(const Pose& X_AB);
PairDistance CoaxialRevolved(const ConvexCore& a, const ConvexCore& b, const Pose& X_AB);
bool IsRevolved(const ConvexCore& core);

// Takes an answer for the cores to the shapes around them.
PairDistance WithRadii(const PairDistance& cores, double radius_a_m, double radius_b_m);

}  // namespace cwm::collision
