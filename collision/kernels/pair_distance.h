// The result of a distance query about a pair of placed geometries; shared by the exact kernels and
// every engine.
#pragma once

#include <cstdint>

#include "collision/geometry/pose.h"

namespace cwm::collision {

// Answers whose error is at most this are called exact.
inline constexpr double kExactTolerance_m = 1e-7;

// The accuracy of an answer, from the strongest to the weakest.
enum class Accuracy : std::uint8_t {
  kExact,        // right to kExactTolerance_m or better
  kBounded,      // off by at most `bound_m`
  kSurfaceOnly,  // an open mesh is involved: distance to its surface, there is no inside
  kDegraded,     // the engine's best effort, no bound known
};

// The solver of an answer. The exact kernels stand in for an engine that fails or measures overlaps
// wrongly.
enum class Solver { kEngine, kKernels };

// The distance from A to B. All vectors are in the frame of the given poses.
struct PairDistance {
  double distance_m = 0;              // signed; negative is penetration depth, 0 is touching
  Vector3 point_a = Vector3::Zero();  // witness on A
  Vector3 point_b = Vector3::Zero();  // witness on B; point_b - point_a = distance_m * normal
  Vector3 normal =
      Vector3::UnitZ();  // unit, from A to B: moving B along it by the depth makes them touch
  Accuracy accuracy = Accuracy::kExact;
  // |distance_m - true| <= bound_m, unless kDegraded. 0 for kExact, which is right to
  // kExactTolerance_m.
  double bound_m = 0;
  Solver solver = Solver::kKernels;
};

}  // namespace cwm::collision
