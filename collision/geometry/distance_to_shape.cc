#include "collision/geometry/distance_to_shape.h"

#include <variant>

namespace cwm {

DistanceToShape::DistanceToShape(const Shape& shape) : shape_(shape) {
  if (const auto* cone = std::get_if<Cone>(&shape)) revolved_.emplace(ProfileOf(*cone));
  if (const auto* cylinder = std::get_if<Cylinder>(&shape)) revolved_.emplace(ProfileOf(*cylinder));
}

DistanceToShape::DistanceToShape(const ShapePart& part) : DistanceToShape(part.shape) {
  vessel_ = part.vessel.get();
}

double DistanceToShape::operator()(const Vector3& p) const {
  if (vessel_ != nullptr) return SignedDistance_m(*vessel_, p);
  return revolved_ ? (*revolved_)(p) : SignedDistance_m(shape_, p);
}

}  // namespace cwm
