// The margins of pairs for which no rule sets another one.
#pragma once

#include "collision/query/query.h"

namespace cwm::collision {

// Refers to the body.
class PairMargins {
 public:
  PairMargins(const QueryBody& body, const QueryOptions& options)
      : body_(body),
        request_m_(options.margin_m),
        support_tolerance_m_(options.support_tolerance_m) {}

  // The margin between the parts in a frame of the body and a part of an obstacle, without
  // deviations of their surfaces. Negative for a support, which the body may reach into.
  double Of(int frame, const Obstacle& object, std::size_t part) const;
  // The margin between the parts in two frames of the body.
  double OfSelfPair(int first, int second) const;
  // The largest margin that `Of` returns for the obstacles of the world.
  double MaxOf(const WorldSnapshot& world) const;

 private:
  double OwnMargin_m(int frame) const;
  bool IsSupportOf(int frame, const std::string& name) const;

  const QueryBody& body_;
  const double request_m_, support_tolerance_m_;
};

}  // namespace cwm::collision
