// The signed distance of many points to one shape.
#pragma once

#include <optional>

#include "collision/geometry/hybrid_model.h"
#include "collision/geometry/revolved_profile.h"

namespace cwm {

// SignedDistance_m (signed_distance.h) of one shape, bit for bit; what does not depend on the point
// is worked out once.
class DistanceToShape {
 public:
  // Which must outlive it.
  explicit DistanceToShape(const Shape& shape);
  explicit DistanceToShape(const ShapePart& part);  // as SignedDistance_m(part, p)
  explicit DistanceToShape(Shape&&) = delete;
  explicit DistanceToShape(ShapePart&&) = delete;

  double operator()(const Vector3& p) const;  // metres; p in the shape's frame

 private:
  const Shape& shape_;
  std::optional<DistanceToRevolvedProfile> revolved_;  // of cylinders and cones
  const VesselShell* vessel_ = nullptr;
};

}  // namespace cwm
