#include "perception/hidden_depth.h"

#include <algorithm>
#include <vector>

#include "collision/geometry/aabb.h"
#include "collision/geometry/signed_distance.h"
#include "perception/cloud/tolerances.h"
#include "perception/solids/plane_solid.h"

namespace cwm::perception {

bool IsFace(const Shape& shape) {
  return IsLoneFace(shape) || std::holds_alternative<Plate>(shape);
}

namespace {

// chosen: the distance between layers, two or three pixels.
constexpr double kLayer_m = 0.01;
// chosen: things that stand on tables and floors are not deeper.
constexpr double kMaxHidden_m = 1;
// chosen: places along each side of a layer; a share of them is known to a percent.
constexpr int kPlacesPerSide = 24;

// chosen: the largest share of a layer behind a box that is seen through. A row of places at the
// edge of the layer is more; mixed pixels are less.
constexpr double kMaxSeenThrough = 0.03;
// chosen: less hidden depth than this is noise at the edges of what was seen.
constexpr double kMinHidden_m = 3 * kLayer_m;

// One side of a shape, whose frame is S: the axis of its outward normal, and its sign.
struct Side {
  Eigen::Index axis = 2;
  double sign = 1;
};

// True for faces, and for boxes so thin that a sliver of a side tells their depth, which may go on.
bool IsFlat(const Shape& shape, const Aabb& bounds_S) {
  return IsFace(shape) || bounds_S.sizes().minCoeff() < kMinHidden_m;
}

// Places in the middle of the shape, in its frame, on a grid across the axis.
std::vector<Vector3> PlacesAcross(const Shape& shape, const Aabb& bounds_S, Eigen::Index axis) {
  const Eigen::Index across = (axis + 1) % 3, beside = (axis + 2) % 3;
  std::vector<Vector3> places;
  for (int i = 0; i < kPlacesPerSide; ++i) {
    for (int j = 0; j < kPlacesPerSide; ++j) {
      Vector3 place = bounds_S.center();
      place[across] =
          bounds_S.min()[across] + bounds_S.sizes()[across] * (i + 0.5) / kPlacesPerSide;
      place[beside] =
          bounds_S.min()[beside] + bounds_S.sizes()[beside] * (j + 0.5) / kPlacesPerSide;
      if (SignedDistance_m(shape, place) < 0) places.push_back(place);
    }
  }
  return places;
}

// True if the place is free or in the ground.
bool IsEmpty(const Vector3& p_L, const HiddenSpaceEvidence& evidence) {
  if (evidence.X_LGround && (evidence.X_LGround->inverse(Eigen::Isometry) * p_L).z() < 0) {
    return true;
  }
  if (evidence.sight != nullptr &&
      evidence.sight->VisibilityAt(p_L.cast<float>(), static_cast<float>(evidence.tolerance_m)) ==
          Visibility::kSeenThrough) {
    return true;
  }
  return false;
}

bool IsInOtherObject(const Vector3& p_L, const HiddenSpaceEvidence& evidence) {
  return std::ranges::any_of(evidence.solids, [&](const SolidOfObject& solid) {
    return solid.object != evidence.object && solid.bounds_L.contains(p_L) &&
           SignedDistance_m(*solid.part, solid.X_LS.inverse(Eigen::Isometry) * p_L) < 0;
  });
}

// How far the shape may extend beyond the side: the depth of the layers that have few empty places.
double HiddenBeyond_m(const ShapePart& part, const Aabb& bounds_S, const Side& side,
                      const Pose& X_LS, const HiddenSpaceEvidence& evidence) {
  const std::vector<Vector3> places = PlacesAcross(part.shape, bounds_S, side.axis);
  const bool is_flat = IsFlat(part.shape, bounds_S);
  const double max_empty =
      (is_flat ? kMajority : kMaxSeenThrough) * static_cast<double>(places.size());
  const double middle_m = 0.5 * bounds_S.sizes()[side.axis];
  double depth_m = 0;
  for (; depth_m < kMaxHidden_m; depth_m += kLayer_m) {
    Vector3 beyond = Vector3::Zero();
    beyond[side.axis] = side.sign * (middle_m + depth_m + 0.5 * kLayer_m);
    const auto empty = std::ranges::count_if(places, [&](const Vector3& p_S) {
      const Vector3 p_L = X_LS * (p_S + beyond);
      return IsEmpty(p_L, evidence) || (!is_flat && IsInOtherObject(p_L, evidence));
    });
    if (static_cast<double>(empty) > max_empty) break;
  }
  return depth_m < kMinHidden_m ? 0 : depth_m;
}

// The bounds with the hidden space beyond all sides.
Aabb BoundsWithHidden(const ShapePart& part, const Pose& X_LS,
                      const HiddenSpaceEvidence& evidence) {
  Aabb bounds_S = TightBounds(part.shape, Pose::Identity());
  const Aabb seen_S = bounds_S;
  Eigen::Index thin = 2;
  if (!std::holds_alternative<Plate>(part.shape)) seen_S.sizes().minCoeff(&thin);
  // The frame's origin stands for a sensor that is not known, as it did for the normals.
  Vector3 viewpoint_L = Vector3::Zero();
  if (evidence.sight != nullptr) viewpoint_L = evidence.sight->viewpoint().cast<double>();
  const Vector3 viewpoint_S = X_LS.inverse(Eigen::Isometry) * viewpoint_L;
  const bool is_flat = IsFlat(part.shape, seen_S);
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    if (is_flat && axis != thin) continue;
    for (const double sign : {-1.0, 1.0}) {
      const bool is_away = sign * (viewpoint_S - seen_S.center())[axis] < 0;
      if (is_flat && !is_away) continue;
      const double hidden_m = HiddenBeyond_m(part, seen_S, {axis, sign}, X_LS, evidence);
      (sign > 0 ? bounds_S.max() : bounds_S.min())[axis] += sign * hidden_m;
    }
  }
  return bounds_S;
}

}  // namespace

void FindHiddenDepth(const Pose& X_LO, const HiddenSpaceEvidence& evidence,
                     std::vector<ShapePart>& shapes) {
  for (ShapePart& part : shapes) {
    if (!IsFace(part.shape) && !(std::holds_alternative<Box>(part.shape) && evidence.sight))
      continue;
    const Aabb seen_S = TightBounds(part.shape, Pose::Identity());
    const Aabb bounds_S = BoundsWithHidden(part, X_LO * part.X_OS, evidence);
    if (bounds_S.isApprox(seen_S)) continue;
    part.hidden = Placed<Box>{.X_FS = part.X_OS * Eigen::Translation3d(bounds_S.center()),
                              .shape = {.size_m = bounds_S.sizes()}};
    if (IsFace(part.shape)) part.role = PartRole::kCompleted;
  }
}

}  // namespace cwm::perception
