#include "collision/engines/solid.h"

#include <algorithm>
#include <utility>

#include "collision/geometry/signed_distance.h"
#include "collision/kernels/exact_geometry.h"

namespace cwm::collision {
namespace {

// chosen: a flat mesh needs a box with a volume. A thicker box is safe, since it only widens the
// bound.
constexpr double kMinThickness_m = 1e-6;

std::vector<Vector3> PointsOf(const ExactGeometry& exact) {
  if (exact.tree() != nullptr) return exact.tree()->component_points();
  const Shape& shape = exact.shape();
  if (const auto* convex = std::get_if<Convex>(&shape)) return {convex->hull->vertices.front()};
  if (const auto* plate = std::get_if<Plate>(&shape)) {
    return {{plate->outline[0].x(), plate->outline[0].y(), -0.5 * plate->thickness_m}};
  }
  return {Vector3::Zero()};  // the other shapes contain their origin
}

bool ContainsPointOf(const Solid& a, const Pose& X_WA, const Solid& b, const Pose& X_WB) {
  if (a.is_open()) return false;
  const Pose X_AB = X_WA.inverse(Eigen::Isometry) * X_WB;
  return std::any_of(b.points().begin(), b.points().end(),
                     [&](const Vector3& p_BQ) { return a.Contains(X_AB * p_BQ); });
}

}  // namespace

Solid::Solid(std::shared_ptr<const ExactGeometry> exact)
    : exact_(std::move(exact)),
      points_(PointsOf(*exact_)),
      bounds_(TightBounds(exact_->shape(), Pose::Identity())) {
  X_SC_.translation() = bounds_.center();
  bounding_box_ = PrepareExact(Box{bounds_.sizes().cwiseMax(kMinThickness_m)});
}

bool Solid::is_open() const { return exact_->IsOpen(); }

bool Solid::Contains(const Vector3& p) const {
  if (is_open() || !bounds_.contains(p)) return false;
  if (exact_->tree() != nullptr) return exact_->tree()->Contains(p);
  return SignedDistance_m(exact_->shape(), p) < 0;
}

bool EitherContainsOther(const Solid& a, const Pose& X_WA, const Solid& b, const Pose& X_WB) {
  return ContainsPointOf(a, X_WA, b, X_WB) || ContainsPointOf(b, X_WB, a, X_WA);
}

PairDistance OverlapBound(const Solid& a, const Pose& X_WA, const Solid& b, const Pose& X_WB) {
  const Pose X_WCa = X_WA * a.X_SC_;
  const Pose X_WCb = X_WB * b.X_SC_;
  PairDistance answer = ExactDistance({*a.bounding_box_, X_WCa}, {*b.bounding_box_, X_WCb});
  // Solids that overlap have overlapping boxes; only rounding can make the distance positive.
  answer.distance_m = std::min(answer.distance_m, -kMinThickness_m);
  answer.point_b = answer.point_a + answer.distance_m * answer.normal;
  answer.bound_m = -answer.distance_m;
  answer.accuracy = a.is_open() || b.is_open() ? Accuracy::kSurfaceOnly : Accuracy::kBounded;
  return answer;
}

}  // namespace cwm::collision
