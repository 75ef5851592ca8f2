#include "perception/primitive_fit/primitive_fit_ends.h"

#include <algorithm>

#include "perception/primitive_fit/primitive_fit_limits.h"

namespace cwm::perception {
namespace {

// Moves the unconstrained, hidden faces of a box to where its inliers end, so that the box claims
// no space that no point shows. The foot of an upright box is on the ground and stays.
void EndAtPoints(const ModelPoints& points, const PointsOnGround& on_ground, PrimitiveFit& fit) {
  const auto* box = std::get_if<Box>(&fit.solid.shape);
  if (box == nullptr || fit.solid.inliers.empty()) return;
  const Vector3 middle = fit.solid.X_MS.translation();
  Vector3 size_m = box->size_m, shift_S = Vector3::Zero();
  for (Eigen::Index k = 0; k < (fit.kind == PrimitiveKind::kUprightBox ? 2 : 3); ++k) {
    const Vector3 along = fit.solid.X_MS.linear().col(k);
    const Interval extent = ExtentAlong(along, points, fit.solid.inliers, Density::kFading);
    const double half_m = 0.5 * box->size_m(k), at_m = along.dot(middle);
    // A face that looks away from the sensor has no points that could pull at it.
    const double viewer_m = along.dot(points.viewpoint) - at_m;
    const double low_gate_m = viewer_m < -half_m ? points.max_gate_m : 0;
    const double high_gate_m = viewer_m > half_m ? points.max_gate_m : 0;
    const double low_m = std::max(-half_m, extent.low_m - at_m - low_gate_m);
    const double high_m = std::min(half_m, extent.high_m - at_m + high_gate_m);
    const bool low_shown = low_m == -half_m, high_shown = high_m == half_m;
    const double low = low_shown ? low_m : extent.low_m - at_m;
    const double high = high_shown ? high_m : extent.high_m - at_m;
    if (!(high - low > 0) || (low_shown && high_shown)) continue;
    size_m(k) = high - low;
    shift_S(k) = 0.5 * (low + high);
  }
  if (size_m == box->size_m) return;
  fit.solid.X_MS.translate(shift_S);
  fit.solid.shape = Box{.size_m = size_m};
  fit.parameters.tail<3>() = size_m;
  const Vector3 at_G = on_ground.X_MG.inverse(Eigen::Isometry) * fit.solid.X_MS.translation();
  fit.parameters.head<2>() = at_G.head<2>();
  if (fit.kind == PrimitiveKind::kTiltedBox) fit.parameters(2) = at_G.z();
}

// Moves the unconstrained ends of lying and leaning solids to where their inliers end. A lying
// solid ends at its points, because its wall is in view from above unless something hides it. The
// upper end of a leaning solid may be as far beyond them as a hidden part is likely to reach
// (kHiddenRadii); its foot stays on the ground.
void EndNearPoints(const ModelPoints& points, const PointsOnGround& on_ground,
                   const ModelerOptions& options, PrimitiveFit& fit) {
  const bool leans = fit.kind == PrimitiveKind::kLeaningCylinder;
  if ((!leans && !IsLying(fit.kind)) || fit.solid.inliers.empty()) return;
  const Eigen::Index radius = leans ? 4 : 3, length = radius + 1;
  const Vector3 axis = fit.solid.X_MS.linear().col(2);
  const double half_m = 0.5 * fit.parameters(length), at_m = axis.dot(fit.solid.X_MS.translation());
  const double max_m = leans ? kHiddenRadii * fit.parameters(radius) : points.max_gate_m;
  const Interval shown = ExtentAlong(axis, points, fit.solid.inliers, Density::kFading);
  const double low_m = shown.low_m - at_m, high_m = shown.high_m - at_m;
  const bool low_ends = leans || low_m + half_m <= max_m, high_ends = half_m - high_m <= max_m;
  if (low_ends && high_ends) return;
  const double from_m = low_ends ? -half_m : low_m, to_m = high_ends ? half_m : high_m;
  const double shift_m = 0.5 * (from_m + to_m);
  PrimitiveParameters x = fit.parameters;
  x.head<2>() += shift_m * (on_ground.X_MG.linear().transpose() * axis).head<2>();
  x(radius) += SlopeOf(fit.kind, x) * shift_m;
  x(length) = to_m - from_m;
  if (!IsValid(fit.kind, x, options)) return;
  const PlacedPrimitive placed = Place(fit.kind, x);
  fit.parameters = x;
  fit.solid.X_MS = on_ground.X_MG * placed.X_GS;
  fit.solid.shape = placed.shape;
}

}  // namespace

void SetFreeEnds(const ModelPoints& points, const PointsOnGround& on_ground,
                 const ModelerOptions& options, PrimitiveFit& fit) {
  EndAtPoints(points, on_ground, fit);
  EndNearPoints(points, on_ground, options, fit);
}

}  // namespace cwm::perception
