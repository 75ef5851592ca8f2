// The least translation that parts two convex cores.
#pragma once

#include "collision/kernels/convex_core.h"

namespace cwm::collision {

struct Penetration {
  // Moving B by this along `normal` makes the cores touch; nothing shorter does. Slightly negative
  // when the cores are apart by a rounding.
  double depth_m = 0;
  Vector3 point_a = Vector3::Zero();  // in the frame of A; point_a - point_b = depth_m * normal
  Vector3 point_b = Vector3::Zero();
  Vector3 normal = Vector3::UnitZ();  // unit, from A to B
  double bound_m = 0;                 // the least translation is at least depth_m - bound_m
};

// For cores that meet or nearly so (GjkOutcome::kTouching). The answer is always a translation that
// parts the cores; how far from the least one it may be is told by `bound_m`: 1e-9 of the extent,
// more where a round core exhausts the budget of work or rounding stops the growth.
//
// The expanding polytope algorithm (van den Bergen 2001) as branch and bound: a polytope inside of
// D = A - B gives lower bounds, the support of D along the normals of its faces gives upper ones.
// Faces that rounding has spoiled can only cost time, never make the answer a wrong one.
Penetration FindPenetration(const CoreDifference& difference);

}  // namespace cwm::collision
