// The nearest of several pairs of parts, and the label of its distance.
#pragma once

#include <algorithm>

#include "collision/query/body_search.h"
#include "collision/query/pair_columns.h"

namespace cwm::collision {

// Keeps the nearest of the pairs that a search visits, if it is within `limit_m`, and whether a
// second one is as near within `tie_m`; with `tie_m` = 0 that is not searched for.
class NearestPair {
 public:
  NearestPair(double limit_m, double tie_m) : limit_m_(limit_m), tie_m_(tie_m) {}

  double reach_m() const { return std::max(0.0, limit_m_ + tie_m_); }
  bool is_found() const { return is_found_; }
  const FoundPair& found() const { return found_; }

  // Measures the pair and returns the reach for the others.
  double Add(const BodySearch::Pair& pair) {
    FoundPair result{
        .answer = pair.engine.Distance(pair.body, pair.object, limit_m_ + tie_m_, pair.work),
        .id = pair.id};
    const double distance_m = result.answer.distance_m;
    if (distance_m <= limit_m_ && (!is_found_ || result < found_)) {
      result.is_tied = is_found_ && found_.answer.distance_m - distance_m <= tie_m_ && tie_m_ > 0;
      is_found_ = true;
      found_ = result;
      limit_m_ = distance_m;
    } else if (is_found_ && tie_m_ > 0 && distance_m - limit_m_ <= tie_m_) {
      found_.is_tied = true;
    }
    return reach_m();
  }

 private:
  double limit_m_;
  double tie_m_;
  bool is_found_ = false;
  FoundPair found_;
};

// Labels the depth of the deepest of several parts, which is a lower bound of the depth of all of
// them. The boxes contain the parts.
void LabelAsBound(const Aabb& body_W, const Aabb& object_W, PairDistance& answer);

}  // namespace cwm::collision
