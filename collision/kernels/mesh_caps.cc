#include "collision/kernels/mesh_caps.h"

#include <algorithm>

#include "collision/geometry/signed_distance.h"
#include "collision/kernels/compound_pair.h"
#include "collision/kernels/exact_geometry.h"

namespace cwm::collision {
namespace {

bool IsNear(const ExactGeometry::Cap& cap, const Pose& X_FS, const PlacedExact& other,
            double reach_m, WorkCounter* work) {
  const Pose X_FC = X_FS * cap.X_SC;
  const PlacedExact around{*cap.around, X_FC};
  if (ExactDistance(around, other, reach_m, work).distance_m <= reach_m) return true;
  return std::ranges::any_of(other.geometry.caps(), [&](const ExactGeometry::Cap& theirs) {
    const Pose X_FT = other.X_FS * theirs.X_SC;
    return ExactDistance(around, {*theirs.around, X_FT}, reach_m).distance_m <= reach_m;
  });
}

// The largest bound of the caps of A that are near. The largest one comes first.
double NearCapBound_m(const PlacedExact& a, const PlacedExact& b, double reach_m,
                      WorkCounter* work) {
  for (const ExactGeometry::Cap& cap : a.geometry.caps()) {
    if (IsNear(cap, a.X_FS, b, reach_m, work)) return cap.bound_m;
  }
  return 0;
}

// An upper bound of the depth of any overlap of the two: that of their convex enclosures.
double EnclosureDepth_m(const PlacedExact& a, const PlacedExact& b) {
  const Pose X_AB = a.X_FS.inverse(Eigen::Isometry) * b.X_FS;
  return WithDepthBound(PairDistance{}, a.geometry, b.geometry, X_AB).bound_m;
}

}  // namespace

CapError CapErrorOf(const PlacedExact& a, const PlacedExact& b, double reach_m, WorkCounter* work) {
  const bool has_half_space =
      a.geometry.kind() == ShapeKind::kHalfSpace || b.geometry.kind() == ShapeKind::kHalfSpace;
  const auto bound_m = [&](double within_m) {
    return NearCapBound_m(a, b, within_m, work) + NearCapBound_m(b, a, within_m, work);
  };
  CapError error;
  if (!has_half_space) error.apart_m = bound_m(reach_m);
  if (error.any() && bound_m(0) > 0) error.depth_m = EnclosureDepth_m(a, b);
  return error;
}

CapError CapErrorAt(const ExactGeometry& shape, const Vector3& p, double reach_m) {
  CapError error;
  for (const ExactGeometry::Cap& cap : shape.caps()) {
    const Vector3 p_C = cap.X_SC.inverse(Eigen::Isometry) * p;
    const double distance_m = SignedDistance_m(cap.around->shape(), p_C);
    if (distance_m > reach_m) continue;
    error.apart_m = std::max(error.apart_m, cap.bound_m);
    if (distance_m <= 0) error.depth_m = std::max(error.depth_m, cap.bound_m);
  }
  return error;
}

bool MayMeetCap(const PlacedExact& shape, const Ray& ray) {
  return std::ranges::any_of(shape.geometry.caps(), [&](const ExactGeometry::Cap& cap) {
    const Pose X_FC = shape.X_FS * cap.X_SC;
    const bool starts_within =
        SignedDistance_m(cap.around->shape(), X_FC.inverse(Eigen::Isometry) * ray.origin) <= 0;
    return starts_within || ExactRay({*cap.around, X_FC}, ray).has_value();
  });
}

PairDistance WithCapError(const PairDistance& answer, const CapError& error) {
  if (!error.any()) return answer;
  PairDistance bounded = answer;
  bounded.accuracy = std::max(answer.accuracy, Accuracy::kBounded);
  if (answer.distance_m < 0) {
    bounded.bound_m = std::max(answer.bound_m, error.apart_m - answer.distance_m);
  } else {
    bounded.bound_m = answer.bound_m + error.apart_m;
    if (error.depth_m > 0) {
      bounded.bound_m = std::max(bounded.bound_m, answer.distance_m + error.depth_m);
    }
  }
  return bounded;
}

}  // namespace cwm::collision
