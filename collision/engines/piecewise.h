// How answers about pieces become the answer about their unions; the same for FCL and Bullet.
#pragma once

#include <algorithm>
#include <limits>

#include "collision/engines/solid.h"
#include "collision/kernels/pair_answer.h"

namespace cwm::collision {

// The answer about (B, A) from the one about (A, B).
inline PairDistance Swapped(PairDistance answer) {
  std::swap(answer.point_a, answer.point_b);
  answer.normal = -answer.normal;
  return answer;
}

// Of all pairs of pieces, the answer with the least signed distance; `distance(i, j)` answers for
// piece i of A and piece j of B.
template <class PieceDistance>
PairDistance LeastOverPieces(std::size_t count_a, std::size_t count_b,
                             const PieceDistance& distance) {
  PairDistance least{.distance_m = std::numeric_limits<double>::infinity()};
  for (std::size_t i = 0; i < count_a; ++i) {
    for (std::size_t j = 0; j < count_b; ++j) {
      const PairDistance answer = distance(i, j);
      if (answer.distance_m < least.distance_m) least = answer;
    }
  }
  return least;
}

// Pieces that overlap say of their union only that its depth is at least theirs; its bounding box
// says how much it is at most.
inline void WidenToUnion(PairDistance& answer, const PairDistance& overlap_bound) {
  answer.bound_m += std::max(0.0, answer.distance_m - overlap_bound.distance_m);
  answer.trust = std::max(answer.trust, Trust::kBounded);
}

}  // namespace cwm::collision
