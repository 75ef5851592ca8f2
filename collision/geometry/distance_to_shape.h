// The signed distance of many points to one shape.
#pragma once

#include <optional>

#include "collision/geometry/revolved_profile.h"
#include "collision/geometry/shape.h"

namespace cwm {

// SignedDistance_m (signed_distance.h) of one shape, bit for bit; what does not depend on the point
// is worked out once.
class DistanceToShape {
 public:
  explicit DistanceToShape(const Shape& shape);  // which must outlive it

  double operator()(const Vector3& p) const;  // metres; p in the shape's frame

 private:
  const Shape& shape_;
  std::optional<DistanceToRevolvedProfile> revolved_;  // of cylinders and cones
};

}  // namespace cwm
