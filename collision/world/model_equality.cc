#include "collision/world/model_equality.h"

#include <algorithm>

namespace cwm::collision {
namespace {

bool SameVessel(const VesselShell* a, const VesselShell* b) {
  return a == b || (a != nullptr && b != nullptr && *a == *b);
}

bool SameHidden(const std::optional<Placed<Box>>& a, const std::optional<Placed<Box>>& b) {
  return a.has_value() == b.has_value() &&
         (!a || (SamePose(a->X_FS, b->X_FS) && a->shape == b->shape));
}

bool Same(const ShapePart& a, const ShapePart& b) {
  return SamePose(a.X_OS, b.X_OS) && a.shape == b.shape && a.role == b.role && a.fit == b.fit &&
         SameVessel(a.vessel.get(), b.vessel.get()) && SameHidden(a.hidden, b.hidden);
}

bool Same(const SurfacePart& a, const SurfacePart& b) {
  return a.point_count == b.point_count && a.surface == b.surface;
}

bool Same(const Handle& a, const Handle& b) {
  return a.shape_index == b.shape_index && a.point_count == b.point_count && a.axis_O == b.axis_O &&
         SamePose(a.bounds.X_FS, b.bounds.X_FS) && a.bounds.shape == b.bounds.shape &&
         a.surface == b.surface;
}

template <class T>
bool SameList(const std::vector<T>& a, const std::vector<T>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const T& x, const T& y) { return Same(x, y); });
}

}  // namespace

bool SamePose(const Pose& X_A, const Pose& X_B) { return X_A.matrix() == X_B.matrix(); }

bool SameModel(const HybridModel& a, const HybridModel& b) {
  return &a == &b || (a.point_count == b.point_count && SameList(a.shapes, b.shapes) &&
                      SameList(a.surfaces, b.surfaces) && SameList(a.handles, b.handles));
}

}  // namespace cwm::collision
