// Tests the exact kernels with difficult pairs: sizes over six decades, half of the pairs touching,
// two thirds aligned or nearly so.
#pragma once

#include <cstdint>
#include <string>

namespace cwm::collision {

struct PairFuzz {
  std::int64_t pairs = 0, failures = 0;
  std::string first;  // the first failure: kinds and fault
};

// Tests `pairs` random pairs. Failures are an exception, a number that is not finite, a normal that
// is not a unit vector, an overlap check that contradicts the sign of the distance, and a depth
// that does not separate the pair along the normal.
PairFuzz FuzzPairs(unsigned seed, std::int64_t pairs);

}  // namespace cwm::collision
