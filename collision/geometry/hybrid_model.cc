#include "collision/geometry/hybrid_model.h"

#include "collision/geometry/signed_distance.h"

namespace cwm {

double SignedDistance_m(const ShapePart& part, const Vector3& p) {
  return part.vessel ? SignedDistance_m(*part.vessel, p) : SignedDistance_m(part.shape, p);
}

Aabb TightBounds(const HybridModel& model, const Pose& X_FO) {
  Aabb bounds;
  for (const ShapePart& part : model.shapes) {
    bounds.extend(TightBounds(part.shape, X_FO * part.X_OS));
  }
  for (const SurfacePart& part : model.surfaces) bounds.extend(TightBounds(part.surface, X_FO));
  for (const Handle& handle : model.handles) {
    if (handle.surface.mesh == nullptr) continue;
    bounds.extend(TightBounds(handle.surface, X_FO));
  }
  return bounds;
}

}  // namespace cwm
