// The distance of two convex cores, after Gilbert, Johnson and Keerthi (1988).
#pragma once

#include <limits>
#include <optional>

#include "collision/kernels/convex_core.h"

namespace cwm::collision {

enum class GjkOutcome {
  kSeparated,  // distance, points and normal are valid
  kTouching,   // the cores meet, or are so near (at most 1e-6 of their extent) that their points
               // define no direction
  kBeyond,     // farther apart than the limit; `distance_m` is a lower bound above the limit
};

struct GjkResult {
  GjkOutcome outcome = GjkOutcome::kTouching;
  double distance_m = 0;              // for kTouching an upper bound
  Vector3 point_a = Vector3::Zero();  // in the frame of A
  Vector3 point_b = Vector3::Zero();
  Vector3 normal = Vector3::UnitZ();  // unit, from A to B
  // For kSeparated: the true distance lies in [distance_m - bound_m, distance_m].
  double bound_m = 0;
  // For kTouching: true if the cores certainly overlap, because a tetrahedron of points of D
  // contains the origin.
  bool overlaps = false;
};

// derived: cores nearer than this share of their extent count as touching, since the direction from
// A to B would have lost half of its digits.
inline constexpr double kTouchingRatio = 1e-9;

// The distance of two cores. Bounded work, no allocation. README.md lists the measured errors.
GjkResult GjkDistance(const CoreDifference& difference,
                      double max_distance_m = std::numeric_limits<double>::infinity());

// True if the cores are nearer than `near_m`, false if they are farther than `far_m` >= near_m;
// faster than the distance. Empty if they are in between or if rounding decides: the caller must
// then measure the distance.
struct GjkLimits {
  double near_m = 0;
  double far_m = 0;
};
std::optional<bool> GjkOverlap(const CoreDifference& difference, const GjkLimits& limits);
inline std::optional<bool> GjkOverlap(const CoreDifference& difference, double radii_m) {
  return GjkOverlap(difference, {radii_m, radii_m});
}

// The point of A that B touches last when B moves out of A by `depth_m` along `normal`: the witness
// point of a penetration, in the frame of A. Found by moving B a little farther, where the nearest
// points are well defined.
Vector3 WitnessOnA(const CoreDifference& difference, double depth_m, const Vector3& normal);

}  // namespace cwm::collision
