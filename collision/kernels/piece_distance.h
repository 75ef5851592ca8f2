// The distance of a point from a convex piece by a short formula. A ball around the point is no
// nearer than that minus its radius.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "collision/kernels/convex_core.h"

namespace cwm::collision {

// The signed distance of a point from a convex piece, in metres: a lower bound if positive, exact
// if negative. Pieces without an exact depth (cones, hulls) never return a negative one.
class PieceDistance {
 public:
  explicit PieceDistance(const ConvexCore& piece) : piece_(piece) {}

  // True if positive values are exact too and ClampToCore is the nearest point of the core.
  bool IsExact() const {
    return std::holds_alternative<Box>(piece_.core) ||
           std::holds_alternative<Cylinder>(piece_.core) ||
           std::holds_alternative<SegmentCore>(piece_.core);
  }

  double operator()(const Vector3& p) const {
    if (const auto* box = std::get_if<Box>(&piece_.core)) {
      return DistanceOfExcess(p.cwiseAbs() - 0.5 * box->size_m) - piece_.radius_m;
    }
    if (const auto* cylinder = std::get_if<Cylinder>(&piece_.core)) {
      const double beside = p.head<2>().norm() - cylinder->radius_m;
      const double above = std::abs(p.z()) - 0.5 * cylinder->length_m;
      return DistanceOfExcess(Vector3(beside, above, -std::numeric_limits<double>::infinity())) -
             piece_.radius_m;
    }
    if (const auto* segment = std::get_if<SegmentCore>(&piece_.core)) {
      const double along = std::clamp(p.z(), -segment->half_length_m, segment->half_length_m);
      return (p - Vector3(0, 0, along)).norm() - piece_.radius_m;
    }
    if (const auto* cone = std::get_if<Cone>(&piece_.core)) {  // bounded by a cylinder around it
      const double beside =
          p.head<2>().norm() - std::max(cone->radius_bottom_m, cone->radius_top_m);
      const double above = std::abs(p.z()) - 0.5 * cone->length_m;
      return Vector2(beside, above).cwiseMax(0.0).norm();
    }
    // Points and hulls are bounded by a ball around them, which gives no depth.
    return std::max((p - piece_.centre).norm() - piece_.extent_m - piece_.radius_m, 0.0);
  }

 private:
  static double DistanceOfExcess(const Vector3& excess) {
    const double deepest = excess.maxCoeff();
    return deepest <= 0 ? deepest : excess.cwiseMax(0.0).norm();
  }

  const ConvexCore& piece_;
};

}  // namespace cwm::collision
