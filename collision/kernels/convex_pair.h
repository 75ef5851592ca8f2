// The signed distance of two bounded convex shapes.
#pragma once

#include <limits>

#include "collision/kernels/convex_core.h"
#include "collision/kernels/pair_answer.h"

namespace cwm::collision {

// In the frame of A. Separated: exact. Overlapping: the least translation; kBounded with its bound
// where the search ran out of work before the bound fell to 1e-7 m. `max_distance_m` as in
// ExactDistance.
PairDistance ConvexDistance(const ConvexCore& a, const ConvexCore& b, const Pose& X_AB,
                            double max_distance_m = std::numeric_limits<double>::infinity());

// Whether the distance is negative, which is sooner told.
bool ConvexOverlap(const ConvexCore& a, const ConvexCore& b, const Pose& X_AB);

// As ConvexDistance, by GJK and EPA alone, whatever closed form the pair has.
PairDistance IterativeConvexDistance(const ConvexCore& a, const ConvexCore& b, const Pose& X_AB,
                                     double max_distance_m);

// Exchanges the roles of A and B; the frame stays.
PairDistance Swapped(const PairDistance& answer);

// Expresses an answer in frame F, given in frame A.
PairDistance InFrame(const Pose& X_FA, const PairDistance& answer);

// The answer that stands for "farther than asked": no witness points.
PairDistance BeyondLimit(double lower_bound_m);
PairDistance JustBeyond(double max_distance_m);  // where no better bound is known than the limit

}  // namespace cwm::collision
