#include "collision/query/nearest_pair.h"

#include <cmath>

namespace cwm::collision {

void LabelAsBound(const Aabb& body_W, const Aabb& object_W, PairDistance& answer) {
  const double max_m = MinSeparation_m(body_W, object_W);
  if (!std::isfinite(max_m)) {  // a tilted half-space has no bounds
    answer.accuracy = Accuracy::kDegraded;
    return;
  }
  answer.accuracy = std::max(answer.accuracy, Accuracy::kBounded);
  answer.bound_m += std::max(0.0, max_m + answer.distance_m);
}

}  // namespace cwm::collision
