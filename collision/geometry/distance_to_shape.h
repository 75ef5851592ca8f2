// The signed distance of many points to one shape.
#pragma once

#include <optional>

#include "collision/geometry/hybrid_model.h"
#include "collision/geometry/revolved_profile.h"

namespace cwm {

// Returns the same bits as SignedDistance_m (signed_distance.h) of one shape, but computes once
// what does not depend on the point.
class DistanceToShape {
 public:
  // Keeps a reference to the shape or part, which must outlive this object.
  explicit DistanceToShape(const Shape& shape);
  explicit DistanceToShape(const ShapePart& part);  // as SignedDistance_m(part, p)
  explicit DistanceToShape(Shape&&) = delete;
  explicit DistanceToShape(ShapePart&&) = delete;

  double operator()(const Vector3& p) const;  // metres; p in the shape's frame

 private:
  const Shape& shape_;
  std::optional<DistanceToRevolvedProfile> revolved_;  // set for cylinders and cones
  const VesselShell* vessel_ = nullptr;
};

}  // namespace cwm
