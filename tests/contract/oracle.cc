#include "tests/contract/oracle.h"

#include <algorithm>
#include <cmath>

namespace cwm::collision {
namespace {

double ExtentOfRings(double bottom_m, double top_m, double length_m, const Vector3& d) {
  const double across = std::hypot(d.x(), d.y());
  return std::max(across * bottom_m - d.z() * length_m / 2, across * top_m + d.z() * length_m / 2);
}

struct Extent {
  const Vector3& d;

  double operator()(const Sphere& s) const { return s.radius_m; }
  double operator()(const Box& s) const { return d.cwiseAbs().dot(s.size_m) / 2; }
  double operator()(const Cylinder& s) const {
    return ExtentOfRings(s.radius_m, s.radius_m, s.length_m, d);
  }
  double operator()(const Cone& s) const {
    return ExtentOfRings(s.radius_bottom_m, s.radius_top_m, s.length_m, d);
  }
  double operator()(const Capsule& s) const {
    return s.radius_m + std::abs(d.z()) * s.length_m / 2;
  }
  double operator()(const Convex& s) const {
    double extent = -INFINITY;
    for (const Vector3& v : s.hull->vertices) extent = std::max(extent, d.dot(v));
    return extent;
  }
  double operator()(const HalfSpace&) const { return NAN; }
  double operator()(const Plate&) const { return NAN; }
  double operator()(const Mesh&) const { return NAN; }
};

}  // namespace

bool HasExtent(const Shape& shape) {
  const ShapeKind kind = KindOf(shape);
  return kind != ShapeKind::kHalfSpace && kind != ShapeKind::kPlate && kind != ShapeKind::kMesh;
}

double Extent_m(const Shape& shape, const Pose& X_WS, const Vector3& direction_W) {
  const Vector3 d = X_WS.linear().transpose() * direction_W;
  return direction_W.dot(X_WS.translation()) + std::visit(Extent{d}, shape);
}

double Gap_m(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB,
             const Vector3& direction_W) {
  return -Extent_m(b, X_WB, -direction_W) - Extent_m(a, X_WA, direction_W);
}

}  // namespace cwm::collision
