#include "tests/collision/kernels/long_double_oracle.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "collision/geometry/aabb.h"

namespace cwm::collision {
namespace {

using Real = long double;
using Point = Eigen::Matrix<Real, 3, 1>;
using Point2 = Eigen::Matrix<Real, 2, 1>;
using Turn = Eigen::Matrix<Real, 3, 3>;

// B in the frame of A; the poses are taken as exact.
struct Relative {
  Point p;
  Turn R;
};
Relative InA(const Pose& X_FA, const Pose& X_FB) {
  const Turn R_AF = X_FA.linear().cast<Real>().transpose();
  return {R_AF * (X_FB.translation().cast<Real>() - X_FA.translation().cast<Real>()),
          R_AF * X_FB.linear().cast<Real>()};
}

Real ToBox(const Point& half, const Point& p) {
  const Point beyond = p.cwiseAbs() - half;
  if (beyond.maxCoeff() <= 0) return beyond.maxCoeff();
  return beyond.cwiseMax(Real(0)).norm();
}

template <class P>
P OnSegment(const P& a, const P& b, const P& p) {
  const P along = b - a;
  const Real squared = along.squaredNorm();
  if (!(squared > 0)) return a;
  return a + std::clamp<Real>((p - a).dot(along) / squared, 0, 1) * along;
}

// The distance from the right half of a truncated cone's section, whose corners are listed upwards.
Real ToCone(const Cone& cone, const Point& p) {
  const Real half = Real(cone.length_m) / 2;
  const std::array<Point2, 4> corners = {Point2(0, -half), Point2(cone.radius_bottom_m, -half),
                                         Point2(cone.radius_top_m, half), Point2(0, half)};
  const Point2 q(std::hypot(p.x(), p.y()), p.z());
  Real nearest = std::numeric_limits<Real>::infinity();
  Real highest = -nearest;
  for (std::size_t i = 0; i < 3; ++i) {
    const Point2 along = corners[i + 1] - corners[i];
    if (!(along.norm() > 0)) continue;
    nearest = std::min(nearest, (q - OnSegment(corners[i], corners[i + 1], q)).norm());
    const Point2 outward = Point2(along.y(), -along.x()) / along.norm();
    highest = std::max(highest, outward.dot(q - corners[i]));
  }
  return highest <= 0 ? highest : nearest;
}

struct ToPoint {
  Point p;
  Real operator()(const Sphere& s) const { return p.norm() - s.radius_m; }
  Real operator()(const Box& s) const { return ToBox(s.size_m.cast<Real>() / 2, p); }
  Real operator()(const Cylinder& s) const {
    return ToCone({s.radius_m, s.radius_m, s.length_m}, p);
  }
  Real operator()(const Cone& s) const { return ToCone(s, p); }
  Real operator()(const Capsule& s) const {
    const Point top(0, 0, Real(s.length_m) / 2);
    return (p - OnSegment<Point>(-top, top, p)).norm() - s.radius_m;
  }
  Real operator()(const HalfSpace&) const { return p.z(); }
  Real operator()(const Plate& s) const {
    const Vector2 far = s.outline[2];
    const Point half = Point(far.x(), far.y(), s.thickness_m) / 2;
    return ToBox(half, p - Point(half.x(), half.y(), -half.z()));
  }
  Real operator()(const Convex&) const { return NAN; }
  Real operator()(const Mesh&) const { return NAN; }
};

// The extent of a shape along a unit direction in its own frame.
struct Reach {
  Point n;
  Real radial() const { return std::hypot(n.x(), n.y()); }
  Real operator()(const Sphere& s) const { return s.radius_m; }
  Real operator()(const Box& s) const { return n.cwiseAbs().dot(s.size_m.cast<Real>()) / 2; }
  Real operator()(const Cylinder& s) const {
    return (*this)(Cone{s.radius_m, s.radius_m, s.length_m});
  }
  Real operator()(const Cone& s) const {
    const Real half = Real(s.length_m) / 2;
    return std::max(s.radius_bottom_m * radial() - half * n.z(),
                    s.radius_top_m * radial() + half * n.z());
  }
  Real operator()(const Capsule& s) const { return s.radius_m + std::abs(n.z()) * s.length_m / 2; }
  Real operator()(const HalfSpace&) const { return NAN; }
  Real operator()(const Plate& s) const {
    Real highest = -std::numeric_limits<Real>::infinity();
    for (const Vector2& p : s.outline) highest = std::max(highest, n.x() * p.x() + n.y() * p.y());
    return highest + std::max<Real>(0, -n.z() * s.thickness_m);
  }
  Real operator()(const Convex& s) const {
    Real highest = -std::numeric_limits<Real>::infinity();
    for (const Vector3& v : s.hull->vertices) highest = std::max(highest, n.dot(v.cast<Real>()));
    return highest;
  }
  Real operator()(const Mesh&) const { return NAN; }
};

// The minimum of a convex function on [0, 1], by ternary search: 120 steps leave 1e-21 of the
// interval.
template <class F>
Real LeastOfConvex(const F& f) {
  Real low = 0, high = 1;
  Real least = std::min(f(low), f(high));
  for (int step = 0; step < 120; ++step) {
    const Real left = low + (high - low) / 3, right = high - (high - low) / 3;
    const Real at_left = f(left), at_right = f(right);
    least = std::min({least, at_left, at_right});
    (at_left < at_right ? high : low) = at_left < at_right ? right : left;
  }
  return least;
}

Real CapsuleToCapsule(const Capsule& a, const Capsule& b, const Relative& X) {
  const Point top_a(0, 0, Real(a.length_m) / 2);
  const Point half_b = X.R.col(2) * (Real(b.length_m) / 2);
  const Point low_b = X.p - half_b, high_b = X.p + half_b;
  return LeastOfConvex([&](Real t) {
           const Point p = (2 * t - 1) * top_a;
           return (p - OnSegment(low_b, high_b, p)).norm();
         }) -
         a.radius_m - b.radius_m;
}

// A core inside the box leaves it across the nearest face of their Minkowski sum: the box's faces,
// and the faces that its edges span with the core.
Real BoxToCapsule(const Box& a, const Capsule& b, const Relative& X) {
  const Point half = a.size_m.cast<Real>() / 2, along = X.R.col(2) * (Real(b.length_m) / 2);
  const Real apart = LeastOfConvex(
      [&](Real t) { return std::max<Real>(0, ToBox(half, X.p + (2 * t - 1) * along)); });
  constexpr Real kMeeting = 1e-16L;  // of the size: far below the asserted accuracy
  if (apart > kMeeting * half.maxCoeff()) return apart - b.radius_m;
  Real least = -std::numeric_limits<Real>::infinity();
  const auto consider = [&](const Point& axis) {
    if (!(axis.norm() > 0)) return;
    const Point n = axis.normalized();
    const Real reach = half.dot(n.cwiseAbs()) + std::abs(along.dot(n));
    least = std::max(least, std::abs(n.dot(X.p)) - reach);
  };
  for (int i = 0; i < 3; ++i) {
    const Point axis = Point::Unit(i);
    consider(axis);
    consider(along.cross(axis));
  }
  return least - b.radius_m;
}

// The distance if the order of the shapes is that of the formulas; empty for the other order.
std::optional<Real> Ordered(const Shape& a, const Pose& X_FA, const Shape& b, const Pose& X_FB) {
  const Relative X = InA(X_FA, X_FB);
  if (const auto* sphere = std::get_if<Sphere>(&b)) {
    return std::visit(ToPoint{X.p}, a) - Real(sphere->radius_m);
  }
  if (std::holds_alternative<HalfSpace>(a)) {
    const Point down_B = -X.R.row(2).transpose();
    return X.p.z() - std::visit(Reach{down_B}, b);
  }
  const auto* capsule_b = std::get_if<Capsule>(&b);
  if (capsule_b == nullptr) return std::nullopt;
  if (const auto* capsule_a = std::get_if<Capsule>(&a)) {
    return CapsuleToCapsule(*capsule_a, *capsule_b, X);
  }
  if (const auto* box = std::get_if<Box>(&a)) return BoxToCapsule(*box, *capsule_b, X);
  return std::nullopt;
}

double Extent(const Shape& shape) {
  if (KindOf(shape) == ShapeKind::kHalfSpace) return 0;
  return TightBounds(shape, Pose::Identity()).sizes().maxCoeff();
}

}  // namespace

bool HasLongDoubleOracle(ShapeKind a, ShapeKind b) {
  using K = ShapeKind;
  if (a == K::kMesh || b == K::kMesh || (a == K::kHalfSpace && b == K::kHalfSpace)) return false;
  if (a == K::kHalfSpace || b == K::kHalfSpace) return true;
  if (a == K::kSphere) return b != K::kConvex;
  if (b == K::kSphere) return a != K::kConvex;
  const auto is_capsule_or_box = [](K kind) { return kind == K::kCapsule || kind == K::kBox; };
  return is_capsule_or_box(a) && is_capsule_or_box(b) && (a == K::kCapsule || b == K::kCapsule);
}

long double LongDoubleDistance_m(const PosedPair& pair) {
  const auto direct = Ordered(pair.a, pair.X_FA, pair.b, pair.X_FB);
  return direct ? *direct : *Ordered(pair.b, pair.X_FB, pair.a, pair.X_FA);
}

double ExtentOf(const PosedPair& pair) {
  return std::max(
      {Extent(pair.a), Extent(pair.b), (pair.X_FA.translation() - pair.X_FB.translation()).norm()});
}

}  // namespace cwm::collision
