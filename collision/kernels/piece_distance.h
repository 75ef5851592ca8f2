// How far places are from a convex piece, by the shortest of formulas: what lies around a place is no
// nearer than that less its radius.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "collision/kernels/convex_core.h"

namespace cwm::collision {

// How far a point is from a convex piece: what is positive is a lower bound, what is negative
// exact.
class PieceDistance {
 public:
  explicit PieceDistance(const ConvexCore& piece) : piece_(piece) {}

  // Whether what is positive is the distance, and ClampedTo the nearest point of the core.
  bool IsExact() const {
    return std::holds_alternative<Box>(piece_.core) ||
           std::holds_alternative<Cylinder>(piece_.core) ||
           std::holds_alternative<SegmentCore>(piece_.core);
  }

  double operator()(const Vector3& p) const {
    if (const auto* box = std::get_if<Box>(&piece_.core)) {
      return OfExcess(p.cwiseAbs() - 0.5 * box->size_m) - piece_.radius_m;
    }
    if (const auto* cylinder = std::get_if<Cylinder>(&piece_.core)) {
      const double beside = p.head<2>().norm() - cylinder->radius_m;
      const double above = std::abs(p.z()) - 0.5 * cylinder->length_m;
      return OfExcess(Vector3(beside, above, -std::numeric_limits<double>::infinity())) -
             piece_.radius_m;
    }
    if (const auto* segment = std::get_if<SegmentCore>(&piece_.core)) {
      const double along = std::clamp(p.z(), -segment->half_length_m, segment->half_length_m);
      return (p - Vector3(0, 0, along)).norm() - piece_.radius_m;
    }
    if (const auto* cone = std::get_if<Cone>(&piece_.core)) {  // by a cylinder around it
      const double beside =
          p.head<2>().norm() - std::max(cone->radius_bottom_m, cone->radius_top_m);
      const double above = std::abs(p.z()) - 0.5 * cone->length_m;
      return Vector2(beside, above).cwiseMax(0.0).norm();
    }
    // Hulls by a ball around them, from which no depth follows.
    return std::max((p - piece_.centre).norm() - piece_.extent_m - piece_.radius_m, 0.0);
  }

 private:
  static double OfExcess(const Vector3& excess) {
    const double deepest = excess.maxCoeff();
    return deepest <= 0 ? deepest : excess.cwiseMax(0.0).norm();
  }

  const ConvexCore& piece_;
};

}  // namespace cwm::collision
