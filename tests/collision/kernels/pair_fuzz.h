// The exact kernels over pairs that hurt: sizes over six decades, half of the pairs kissing, two
// thirds aligned or nearly so.
#pragma once

#include <cstdint>
#include <string>

namespace cwm::collision {

struct PairFuzz {
  std::int64_t pairs = 0, failures = 0;
  std::string first;  // of the failures: which kinds, and what is wrong
};

// A failure is something thrown, a number that is none, a normal that is not unit, a yes or no that
// is not the sign of the distance, or a depth by which the pair does not part along the normal.
PairFuzz FuzzPairs(unsigned seed, std::int64_t pairs);

}  // namespace cwm::collision
