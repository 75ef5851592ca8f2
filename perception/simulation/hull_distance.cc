#include "perception/simulation/hull_distance.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <optional>
#include <variant>

#include "collision/geometry/support.h"

namespace cwm::perception {
namespace {

// The core of a sphere or a capsule is its centre or axis; the shape is the core grown by the
// radius.
struct Core {
  Vector3 operator()(const Sphere&) const { return Vector3::Zero(); }
  Vector3 operator()(const Capsule& capsule) const {
    return {0, 0, std::copysign(0.5 * capsule.length_m, d.z())};
  }
  Vector3 operator()(const Box& box) const { return SupportPoint(box, d); }
  Vector3 operator()(const Cylinder& cylinder) const { return SupportPoint(cylinder, d); }
  Vector3 operator()(const Cone& cone) const { return SupportPoint(cone, d); }
  Vector3 operator()(const Convex& convex) const { return SupportPoint(convex.hull->vertices, d); }
  Vector3 operator()(const Mesh& mesh) const { return SupportPoint(mesh.mesh->vertices, d); }
  Vector3 operator()(const Plate& plate) const {
    const Vector2 corner = *std::max_element(plate.outline.begin(), plate.outline.end(),
                                             [&](const Vector2& p, const Vector2& q) {
                                               return p.dot(d.head<2>()) < q.dot(d.head<2>());
                                             });
    return {corner.x(), corner.y(), d.z() > 0 ? 0 : -plate.thickness_m};
  }
  Vector3 operator()(const HalfSpace&) const {
    assert(false && "half-spaces have no hull");
    return Vector3::Zero();
  }

  Vector3 d;
};

Vector3 CorePoint(const Placed<>& placed, const Vector3& d) {
  return placed.X_FS * std::visit(Core{.d = placed.X_FS.linear().transpose() * d}, placed.shape);
}

double Growth_m(const Shape& shape) {
  if (const auto* sphere = std::get_if<Sphere>(&shape)) return sphere->radius_m;
  if (const auto* capsule = std::get_if<Capsule>(&shape)) return capsule->radius_m;
  return 0;
}

struct Simplex {
  std::array<Vector3, 4> points;
  int size = 0;
};

using Edges = Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, 3>;
using Weights = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 3, 1>;

// The point of least norm of the affine hull, if it lies within the simplex; else empty.
std::optional<Vector3> MinNormPoint(const Simplex& simplex) {
  const Vector3& first = simplex.points[0];
  if (simplex.size == 1) return first;
  Edges edges(3, simplex.size - 1);
  for (int i = 1; i < simplex.size; ++i) edges.col(i - 1) = simplex.points[i] - first;
  const Weights weights = (edges.transpose() * edges).ldlt().solve(-edges.transpose() * first);
  if (!weights.allFinite() || weights.minCoeff() < 0 || weights.sum() > 1) return std::nullopt;
  return Vector3(first + edges * weights);
}

// The point of the simplex nearest to the origin; reduces the simplex to the face that contains it.
// All fifteen faces are tested, which is short and has no special cases.
Vector3 Reduce(Simplex& simplex) {
  Vector3 nearest = simplex.points[0];
  Simplex best{.points = {simplex.points[0]}, .size = 1};
  for (int mask = 1; mask < 1 << simplex.size; ++mask) {
    Simplex face;
    for (int i = 0; i < simplex.size; ++i) {
      if (mask >> i & 1) face.points[face.size++] = simplex.points[i];
    }
    const std::optional<Vector3> point = MinNormPoint(face);
    if (!point || point->squaredNorm() >= nearest.squaredNorm()) continue;
    nearest = *point;
    best = face;
  }
  simplex = best;
  return nearest;
}

constexpr double kTolerance_m = 1e-6;  // as the header promises; far below any sensor's noise
constexpr double kTouchTolerance_m = 1e-4;

}  // namespace

// Gilbert, Johnson and Keerthi 1988: every support point is a lower bound of the distance.
double HullDistance_m(const Placed<>& a, const Placed<>& b) {
  constexpr int kIterations = 100;  // round rims need about 30
  const double growth_m = Growth_m(a.shape) + Growth_m(b.shape);
  Vector3 nearest = CorePoint(a, Vector3::UnitX()) - CorePoint(b, -Vector3::UnitX());
  Simplex simplex{.points = {nearest}, .size = 1};
  double bound_m = 0;
  for (int i = 0; i < kIterations; ++i) {
    const double distance_m = nearest.norm();
    if (distance_m < kTolerance_m) return 0;
    const Vector3 support = CorePoint(a, -nearest) - CorePoint(b, nearest);
    bound_m = std::max(bound_m, support.dot(nearest) / distance_m);
    if (distance_m - bound_m < kTolerance_m || simplex.size == 4) break;
    simplex.points[simplex.size++] = support;
    nearest = Reduce(simplex);
  }
  return std::max(0.0, bound_m - growth_m);
}

double Clearance_m(const SimulatedObject& a, const SimulatedObject& b) {
  double min_m = std::numeric_limits<double>::infinity();
  for (const Placed<>& part_a : a.parts) {
    const Placed<> a_W{.X_FS = a.X_WO * part_a.X_FS, .shape = part_a.shape};
    for (const Placed<>& part_b : b.parts) {
      const Placed<> b_W{.X_FS = b.X_WO * part_b.X_FS, .shape = part_b.shape};
      min_m = std::min(min_m, HullDistance_m(a_W, b_W));
    }
  }
  return min_m;
}

// Conservative advancement: an object at a distance of `gap` may move by `gap` in any direction.
bool SlideUntilTouching(const Vector3& direction_W, const SimulatedObject& obstacle,
                        SimulatedObject& object) {
  constexpr int kSteps = 100;
  constexpr double kFarthest_m = 1;
  const Pose X_WO = object.X_WO;
  double moved_m = 0;
  for (int i = 0; i < kSteps; ++i) {
    const double gap_m = Clearance_m(object, obstacle);
    if (gap_m == 0 || moved_m > kFarthest_m) break;
    if (gap_m <= kTouchTolerance_m) return true;
    // Half of the tolerance remains, so that touching objects never overlap.
    const double step_m = gap_m - 0.5 * kTouchTolerance_m;
    object.X_WO.pretranslate(step_m * direction_W);
    moved_m += step_m;
  }
  object.X_WO = X_WO;
  return false;
}

}  // namespace cwm::perception
