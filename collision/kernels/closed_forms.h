// Pairs that have a formula. All answers are in the frame of A (the first argument), with the
// witness points and the normal of PairDistance.
#pragma once

#include "collision/kernels/convex_core.h"
#include "collision/kernels/pair_distance.h"

namespace cwm::collision {

// The distance of a half-space A and a bounded convex B. Exact, also as the minimum translation.
PairDistance HalfSpaceToConvex(const ConvexCore& b, const Pose& X_AB);

// The distance of two capsules, by the nearest points of their segments.
PairDistance CapsuleToCapsule(const Capsule& a, const Capsule& b, const Pose& X_AB);

// The distance of a box and a capsule. The squared distance of the box to a point of the segment is
// a convex, piecewise quadratic function of the point's position, whose minimum is found piece by
// piece. Overlap is measured along separating axes.
PairDistance BoxToCapsule(const Box& a, const Capsule& b, const Pose& X_AB);

// The least overlap over the 15 axes that can separate two boxes (Gottschalk 1996): the least
// translation if they overlap. If they do not, -depth_m is only a lower bound of their distance.
struct BoxOverlap {
  double depth_m;  // negative if an axis separates them
  Vector3 normal;  // unit, from A to B, in the frame of A
};
BoxOverlap MinBoxOverlap(const Box& a, const Box& b, const Pose& X_AB);
// True if that depth is positive. The first separating axis ends the search.
bool BoxesOverlap(const Box& a, const Box& b, const Pose& X_AB);

// The distance of cylinders, cones and capsules with parallel axes: their Minkowski difference is
// again a solid of revolution, with the sum of their profiles. Precondition: AxesAreParallel(X_AB).
bool AxesAreParallel(const Pose& X_AB);
PairDistance ParallelRevolvedDistance(const ConvexCore& a, const ConvexCore& b, const Pose& X_AB);
bool IsRevolved(const ConvexCore& core);

// Converts an answer for the cores to one for the shapes, whose balls have the given radii.
PairDistance WithRadii(const PairDistance& cores, double radius_a_m, double radius_b_m);

}  // namespace cwm::collision
