// Combines answers about pieces into the answer about their unions, for FCL and Bullet.
#pragma once

#include <algorithm>
#include <limits>

#include "collision/engines/solid.h"
#include "collision/kernels/pair_distance.h"

namespace cwm::collision {

// The answer about (B, A) from the one about (A, B).
inline PairDistance Swapped(PairDistance answer) {
  std::swap(answer.point_a, answer.point_b);
  answer.normal = -answer.normal;
  return answer;
}

// The answer with the least signed distance over all pairs of pieces; `distance(i, j)` answers for
// piece i of A and piece j of B.
template <class PieceDistance>
PairDistance MinOverPieces(std::size_t count_a, std::size_t count_b,
                           const PieceDistance& distance) {
  PairDistance min{.distance_m = std::numeric_limits<double>::infinity()};
  for (std::size_t i = 0; i < count_a; ++i) {
    for (std::size_t j = 0; j < count_b; ++j) {
      const PairDistance answer = distance(i, j);
      if (answer.distance_m < min.distance_m) min = answer;
    }
  }
  return min;
}

// Widens the bound of an overlap of pieces. The depth of the union is at least that of its pieces,
// and at most the one in `overlap_bound`, from the bounding boxes.
inline void WidenToUnion(PairDistance& answer, const PairDistance& overlap_bound) {
  answer.bound_m += std::max(0.0, answer.distance_m - overlap_bound.distance_m);
  answer.accuracy = std::max(answer.accuracy, Accuracy::kBounded);
}

}  // namespace cwm::collision
