// What a pair of placed geometries is asked and what it answers; shared by the exact kernels and
// every engine.
#pragma once

#include <cstdint>

#include "collision/geometry/pose.h"

namespace cwm::collision {

// Answers whose error is at most this are called exact.
inline constexpr double kExactTolerance_m = 1e-7;

// How far an answer may be believed. Ordered: later is weaker.
enum class Trust : std::uint8_t {
  kExact,        // right to kExactTolerance_m or better
  kBounded,      // off by at most `bound_m`
  kSurfaceOnly,  // an open mesh is involved: distance to its surface, there is no inside
  kDegraded,     // the engine's best effort, no bound known
};

// Whose computation an answer is: where an engine fails, or measures overlaps wrongly, the exact
// kernels stand in for it.
enum class Solver { kEngine, kKernels };

// A before B. All vectors in the frame that the poses were given in.
struct PairDistance {
  double distance_m = 0;              // signed; negative is penetration depth, 0 is touching
  Vector3 point_a = Vector3::Zero();  // witness on A
  Vector3 point_b = Vector3::Zero();  // witness on B; point_b - point_a = distance_m * normal
  Vector3 normal =
      Vector3::UnitZ();  // unit, from A to B: moving B along it by the depth makes them touch
  Trust trust = Trust::kExact;
  // |distance_m - true| <= bound_m, unless kDegraded; 0 of kExact, which is right to its tolerance.
  double bound_m = 0;
  Solver solver = Solver::kKernels;
};

}  // namespace cwm::collision
