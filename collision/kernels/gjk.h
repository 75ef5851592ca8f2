// The distance of two convex cores, after Gilbert, Johnson and Keerthi (1988).
#pragma once

#include <limits>
#include <optional>

#include "collision/kernels/convex_core.h"

namespace cwm::collision {

enum class GjkOutcome {
  kSeparated,  // distance, points and normal are right
  kTouching,  // the cores meet, or are so near (1e-6 of their extent at most) that their points tell
              // no direction
  kBeyond,    // farther apart than asked for; `distance_m` is a lower bound above the limit
};

struct GjkAnswer {
  GjkOutcome outcome = GjkOutcome::kTouching;
  double distance_m = 0;              // of kTouching: at most that
  Vector3 point_a = Vector3::Zero();  // in the frame of A
  Vector3 point_b = Vector3::Zero();
  Vector3 normal = Vector3::UnitZ();  // unit, from A to B
  double bound_m = 0;  // of kSeparated: the distance is at least distance_m - bound_m, never more
  // Of kTouching: the cores overlap for certain, a tetrahedron of points of D is around the origin.
  bool overlaps = false;
};

// Cores nearer than this share of their extent count as touching: a direction from A to B would
// have lost half of its digits.
inline constexpr double kTouchingShare = 1e-9;

// Bounded work, no allocation. Measured errors: README.md.
GjkAnswer GjkDistance(const CoreDifference& difference,
                      double max_distance_m = std::numeric_limits<double>::infinity());

// Whether the cores are nearer than `near_m` or else farther than `far_m`, which is no less:
// sooner told than how near they are. Nothing where they are in between, or where a rounding
// decides: then the distance must tell.
struct GjkLimits {
  double near_m = 0;
  double far_m = 0;
};
std::optional<bool> GjkOverlap(const CoreDifference& difference, const GjkLimits& limits);
inline std::optional<bool> GjkOverlap(const CoreDifference& difference, double radii_m) {
  return GjkOverlap(difference, {radii_m, radii_m});
}

// The point of A that B touches last when it is moved by `depth_m` along `normal` and so parts from
// A: the witness of a penetration, in the frame of A. B is moved a little farther, where the
// nearest points are plain.
Vector3 LastTouchOnA(const CoreDifference& difference, double depth_m, const Vector3& normal);

}  // namespace cwm::collision
