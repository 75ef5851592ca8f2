#include "collision/geometry/quick_bounds.h"

namespace cwm {

bool HasManyVertices(const Shape& shape) {
  const ShapeKind kind = KindOf(shape);
  return kind == ShapeKind::kMesh || kind == ShapeKind::kConvex || kind == ShapeKind::kPlate;
}

Aabb BoundsOfBox(const Aabb& box_O, const Pose& X_FO) {
  const Vector3 centre_F = X_FO * box_O.center();
  const Vector3 reach = X_FO.linear().cwiseAbs() * (0.5 * box_O.sizes());
  return {centre_F - reach, centre_F + reach};
}

}  // namespace cwm
