// The signed distance of two bounded convex shapes.
#pragma once

#include <limits>

#include "collision/kernels/convex_core.h"
#include "collision/kernels/pair_distance.h"

namespace cwm::collision {

// The signed distance, in the frame of A; minus the length of the minimum translation if they
// overlap. kExact, or kBounded if the search ended before its bound fell to 1e-7 m. See
// ExactDistance for `max_distance_m`.
PairDistance ConvexDistance(const ConvexCore& a, const ConvexCore& b, const Pose& X_AB,
                            double max_distance_m = std::numeric_limits<double>::infinity());

// True if the distance is negative, which is faster to find than the distance.
bool ConvexOverlap(const ConvexCore& a, const ConvexCore& b, const Pose& X_AB);

// The same as ConvexDistance, by GJK and EPA alone, even if the pair has a closed form.
PairDistance IterativeConvexDistance(const ConvexCore& a, const ConvexCore& b, const Pose& X_AB,
                                     double max_distance_m);

// Exchanges the roles of A and B; the frame stays.
PairDistance Swapped(const PairDistance& answer);

// Transforms an answer from frame A to frame F.
PairDistance InFrame(const Pose& X_FA, const PairDistance& answer);

// The answer for a pair that is farther apart than the limit, without witness points.
PairDistance BeyondLimit(double lower_bound_m);
PairDistance FartherThan(
    double max_distance_m);  // if no better lower bound than the limit is known

}  // namespace cwm::collision
