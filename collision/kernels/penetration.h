// The minimum translation that separates two convex cores.
#pragma once

#include "collision/kernels/convex_core.h"

namespace cwm::collision {

struct Penetration {
  // Moving B by this along `normal` makes the cores touch; no shorter translation does (up to
  // bound_m). Slightly negative if rounding separates the cores.
  double depth_m = 0;
  Vector3 point_a = Vector3::Zero();  // in the frame of A; point_a - point_b = depth_m * normal
  Vector3 point_b = Vector3::Zero();
  Vector3 normal = Vector3::UnitZ();  // unit, from A to B
  double bound_m = 0;                 // the minimum translation is at least depth_m - bound_m
};

// The penetration of cores that meet or nearly meet (GjkOutcome::kTouching). The answer is always a
// translation that separates the cores, and at most `bound_m` longer than the least one: 1e-9 of
// the extent, more if a round core exhausts the budget of work or rounding stops the growth.
//
// The expanding polytope algorithm (van den Bergen 2001) as branch and bound: a polytope inside
// D = A - B gives lower bounds, the support of D along the normals of its faces gives upper bounds.
// Faces that rounding has spoiled can only cost time, never falsify the answer.
Penetration FindPenetration(const CoreDifference& difference);

}  // namespace cwm::collision
