#include "collision/geometry/hybrid_model.h"

#include <algorithm>

#include "collision/geometry/signed_distance.h"

namespace cwm {

double SignedDistance_m(const ShapePart& part, const Vector3& p) {
  return part.vessel ? SignedDistance_m(*part.vessel, p) : SignedDistance_m(part.shape, p);
}

double HiddenDepth_m(const ShapePart& part) {
  if (!part.hidden) return 0;
  const Pose X_BS = part.hidden->X_FS.inverse(Eigen::Isometry) * part.X_OS;
  const Aabb seen_B = TightBounds(part.shape, X_BS);
  const Vector3 half_m = 0.5 * part.hidden->shape.size_m;
  return std::max({0.0, (half_m - seen_B.max()).maxCoeff(), (half_m + seen_B.min()).maxCoeff()});
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
