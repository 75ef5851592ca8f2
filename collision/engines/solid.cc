#include "collision/engines/solid.h"

#include <algorithm>
#include <cmath>

#include "collision/geometry/signed_distance.h"

namespace cwm::collision {
namespace {

// A flat mesh still needs a box with a volume. Thicker is safe: the bound grows by it.
constexpr double kThinnest_m = 1e-6;

std::vector<Vector3> PointsOf(const Shape& shape) {
  if (const auto* mesh = std::get_if<Mesh>(&shape)) return ComponentPoints(*mesh->mesh);
  if (const auto* convex = std::get_if<Convex>(&shape)) return {convex->hull->vertices.front()};
  if (const auto* plate = std::get_if<Plate>(&shape)) {
    return {{plate->outline[0].x(), plate->outline[0].y(), -0.5 * plate->thickness_m}};
  }
  return {Vector3::Zero()};  // the others are centred
}

bool HoldsPointOf(const Solid& a, const Pose& X_WA, const Solid& b, const Pose& X_WB) {
  const Pose X_AB = X_WA.inverse(Eigen::Isometry) * X_WB;
  return std::any_of(b.points().begin(), b.points().end(),
                     [&](const Vector3& p_BQ) { return a.Contains(X_AB * p_BQ); });
}

}  // namespace

Solid::Solid(const Shape& shape)
    : shape_(shape), points_(PointsOf(shape)), bounds_(TightBounds(shape, Pose::Identity())) {
  if (const auto* mesh = std::get_if<Mesh>(&shape)) {
    is_open_ = !mesh->watertight;
    if (mesh->watertight) closed_mesh_.emplace(mesh->mesh);
  }
  X_SC_.translation() = bounds_.center();
  bounding_box_ = PrepareExact(Box{bounds_.sizes().cwiseMax(kThinnest_m)});
}

bool Solid::Contains(const Vector3& p) const {
  if (is_open_ || !bounds_.contains(p)) return false;
  if (closed_mesh_.has_value()) return closed_mesh_->Contains(p);
  return SignedDistance_m(shape_, p) < 0;
}

bool OneHoldsPartOfOther(const Solid& a, const Pose& X_WA, const Solid& b, const Pose& X_WB) {
  return HoldsPointOf(a, X_WA, b, X_WB) || HoldsPointOf(b, X_WB, a, X_WA);
}

PairDistance OverlapBound(const Solid& a, const Pose& X_WA, const Solid& b, const Pose& X_WB) {
  const Pose X_WCa = X_WA * a.X_SC_;
  const Pose X_WCb = X_WB * b.X_SC_;
  PairDistance answer = ExactDistance({*a.bounding_box_, X_WCa}, {*b.bounding_box_, X_WCb});
  // Solids that overlap have overlapping boxes; rounding alone can say otherwise.
  answer.distance_m = std::min(answer.distance_m, -kThinnest_m);
  answer.point_b = answer.point_a + answer.distance_m * answer.normal;
  answer.trust = Trust::kBounded;
  answer.bound_m = -answer.distance_m;
  if (a.is_open() || b.is_open()) answer.trust = Trust::kSurfaceOnly;
  return answer;
}

}  // namespace cwm::collision
