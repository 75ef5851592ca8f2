#include "collision/engines/solid.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "collision/geometry/signed_distance.h"
#include "collision/kernels/exact_geometry.h"

namespace cwm::collision {
namespace {

// A flat mesh still needs a box with a volume. Thicker is safe: the bound grows by it.
constexpr double kThinnest_m = 1e-6;

// One vertex of each connected component.
std::vector<Vector3> ComponentPoints(const TriangleMesh& mesh) {
  std::vector<std::uint32_t> parent(mesh.vertices.size());
  std::iota(parent.begin(), parent.end(), 0u);
  const auto root = [&](std::uint32_t v) {
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
  };
  for (const auto& t : mesh.triangles) {
    const std::uint32_t a = root(t[0]);
    parent[root(t[1])] = a;
    parent[root(t[2])] = a;
  }
  std::vector<Vector3> points;
  std::vector<bool> seen(mesh.vertices.size(), false);
  for (const auto& t : mesh.triangles) {
    const std::uint32_t component = root(t[0]);
    if (seen[component]) continue;
    seen[component] = true;
    points.push_back(mesh.vertices[t[0]]);
  }
  return points;
}

std::vector<Vector3> PointsOf(const Shape& shape) {
  if (const auto* mesh = std::get_if<Mesh>(&shape)) return ComponentPoints(*mesh->mesh);
  if (const auto* convex = std::get_if<Convex>(&shape)) return {convex->hull->vertices.front()};
  if (const auto* plate = std::get_if<Plate>(&shape)) {
    return {{plate->outline[0].x(), plate->outline[0].y(), -0.5 * plate->thickness_m}};
  }
  return {Vector3::Zero()};  // the others are centred
}

bool HoldsPointOf(const Solid& a, const Pose& X_WA, const Solid& b, const Pose& X_WB) {
  if (a.is_open()) return false;
  const Pose X_AB = X_WA.inverse(Eigen::Isometry) * X_WB;
  return std::any_of(b.points().begin(), b.points().end(),
                     [&](const Vector3& p_BQ) { return a.Contains(X_AB * p_BQ); });
}

}  // namespace

Solid::Solid(std::shared_ptr<const ExactGeometry> exact)
    : exact_(std::move(exact)),
      points_(PointsOf(exact_->shape())),
      bounds_(TightBounds(exact_->shape(), Pose::Identity())) {
  X_SC_.translation() = bounds_.center();
  bounding_box_ = PrepareExact(Box{bounds_.sizes().cwiseMax(kThinnest_m)});
}

bool Solid::is_open() const { return exact_->IsOpen(); }

bool Solid::Contains(const Vector3& p) const {
  if (is_open() || !bounds_.contains(p)) return false;
  if (exact_->tree() != nullptr) return exact_->tree()->Encloses(p);
  return SignedDistance_m(exact_->shape(), p) < 0;
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
  answer.bound_m = -answer.distance_m;
  answer.trust = a.is_open() || b.is_open() ? Trust::kSurfaceOnly : Trust::kBounded;
  return answer;
}

}  // namespace cwm::collision
