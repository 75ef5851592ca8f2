#include "collision/geometry/signed_distance.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "collision/geometry/revolved_profile.h"
#include "collision/geometry/segment.h"
#include "collision/geometry/solid_distance-inl.h"

namespace cwm {
namespace {

namespace formula = HWY_NAMESPACE;  // compiled for what every processor has
using Triple = formula::Triple<double>;

Triple TripleOf(const Vector3& v) { return {v.x(), v.y(), v.z()}; }

// Nearer to a sharp edge than this share of the shape's size, the direction away from it is lost in
// the rounding of poses (2^-52 of coordinates that may be thousands of sizes) and a face's normal
// is used instead.
constexpr double kDistanceRoundoff = 1e-11;

// The border of a plate's outline or holes nearest to a point, and the direction away from the
// solid there.
struct BorderPoint {
  double signed_distance_m = std::numeric_limits<double>::infinity();
  Vector2 nearest = Vector2::Zero();
  Vector2 normal = Vector2::UnitX();
};

// Unit normal of the ring's edge nearest to a point on it, away from the solid.
Vector2 OutwardOnBorder(const Polygon& ring, bool is_hole, const Vector2& point) {
  Vector2 along = Vector2::UnitX();
  double best = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0, j = ring.size() - 1; i < ring.size(); j = i++) {
    const double distance = (NearestOnSegment(ring[j], ring[i], point) - point).squaredNorm();
    if (distance >= best) continue;
    best = distance;
    along = (ring[i] - ring[j]).normalized();
  }
  const Vector2 right(along.y(), -along.x());
  return (SignedArea_m2(ring) > 0) != is_hole ? right : Vector2(-right);
}

double SizeOf(const Plate& plate) {
  double size = plate.thickness_m;
  for (const Vector2& p : plate.outline) size = std::max(size, p.cwiseAbs().maxCoeff());
  return size;
}

// The geometry of a ring and a point.
struct RingPoint {
  double squared_m2 = std::numeric_limits<double>::infinity();
  Vector2 nearest = Vector2::Zero();
  Vector2 along = Vector2::Zero();  // the edge that holds it; zero at a vertex
};

RingPoint NearestOnRing(const Polygon& ring, const Vector2& p) {
  RingPoint best;
  for (std::size_t i = 0, j = ring.size() - 1; i < ring.size(); j = i++) {
    const Vector2 nearest = NearestOnSegment(ring[j], ring[i], p);
    const double squared_m2 = (nearest - p).squaredNorm();
    if (squared_m2 >= best.squared_m2) continue;
    const bool at_vertex = nearest == ring[j] || nearest == ring[i];
    best = {squared_m2, nearest, at_vertex ? Vector2::Zero() : Vector2(ring[i] - ring[j])};
  }
  return best;
}

// Away from the ring at the point nearest to `p`, on the side of `p`. An edge keeps the digits that
// a small offset has lost.
Vector2 TowardsPoint(const RingPoint& at, const Vector2& p) {
  const Vector2 offset = p - at.nearest;
  if (at.along.isZero(0)) return offset.normalized();
  const Vector2 right = Vector2(at.along.y(), -at.along.x()).normalized();
  return right.dot(offset) < 0 ? Vector2(-right) : right;
}

BorderPoint NearestOnPlateBorder(const Plate& plate, const Vector2& p) {
  bool inside = Contains(plate.outline, p);
  const Polygon* nearest_ring = &plate.outline;
  RingPoint at = NearestOnRing(plate.outline, p);
  for (const Polygon& hole : plate.holes) {
    inside = inside && !Contains(hole, p);
    const RingPoint candidate = NearestOnRing(hole, p);
    if (candidate.squared_m2 >= at.squared_m2) continue;
    at = candidate;
    nearest_ring = &hole;
  }
  const double distance = std::sqrt(at.squared_m2);
  const double sign = inside ? -1 : 1;
  if (distance > kDistanceRoundoff * SizeOf(plate)) {
    return {sign * distance, at.nearest, sign * TowardsPoint(at, p)};
  }
  return {sign * distance, at.nearest,
          OutwardOnBorder(*nearest_ring, nearest_ring != &plate.outline, at.nearest)};
}

}  // namespace

SurfacePoint NearestSurfacePoint(const Sphere& sphere, const Vector3& p) {
  const double norm = p.norm();
  const Vector3 normal = norm > 0 ? Vector3(p / norm) : Vector3::UnitZ();
  return {formula::DistanceToSphere_m(TripleOf(p), sphere.radius_m), sphere.radius_m * normal,
          normal};
}

SurfacePoint NearestSurfacePoint(const Box& box, const Vector3& p) {
  const Vector3 half = 0.5 * box.size_m;
  const Vector3 nearest = p.cwiseMax(-half).cwiseMin(half);
  const double distance = formula::DistanceToBox_m(TripleOf(p), TripleOf(half));
  if (distance > kDistanceRoundoff * half.maxCoeff()) {
    return {distance, nearest, (p - nearest) / distance};
  }
  Eigen::Index axis;
  (half - p.cwiseAbs()).minCoeff(&axis);
  Vector3 normal = Vector3::Zero(), on_face = nearest;
  normal[axis] = std::copysign(1.0, p[axis]);
  on_face[axis] = std::copysign(half[axis], p[axis]);
  // Next to an edge the distance keeps the digits that the direction has lost.
  return {distance, on_face, normal};
}

SurfacePoint NearestSurfacePoint(const Cylinder& cylinder, const Vector3& p) {
  return NearestOnRevolvedProfile(ProfileOf(cylinder), p).surface;
}

SurfacePoint NearestSurfacePoint(const Cone& cone, const Vector3& p) {
  return NearestOnRevolvedProfile(ProfileOf(cone), p).surface;
}

SurfacePoint NearestSurfacePoint(const Capsule& capsule, const Vector3& p) {
  const double half = 0.5 * capsule.length_m;
  const Vector3 core(0, 0, std::clamp(p.z(), -half, half));
  const Vector3 offset = p - core;
  const double norm = offset.norm();
  // On the core every radial direction is valid.
  const Vector3 normal = norm > 0 ? Vector3(offset / norm) : Vector3::UnitX();
  return {formula::DistanceToSphere_m(TripleOf(offset), capsule.radius_m),
          core + capsule.radius_m * normal, normal};
}

SurfacePoint NearestSurfacePoint(const HalfSpace&, const Vector3& p) {
  return {p.z(), Vector3(p.x(), p.y(), 0), Vector3::UnitZ()};
}

SurfacePoint NearestSurfacePoint(const Plate& plate, const Vector3& p) {
  const BorderPoint border = NearestOnPlateBorder(plate, p.head<2>());
  // The plate is the product of its outline and the interval [-thickness, 0].
  const bool upper = p.z() >= -0.5 * plate.thickness_m;
  const double face_z = upper ? 0 : -plate.thickness_m;
  const double face_distance = upper ? p.z() : -plate.thickness_m - p.z();
  const Vector3 face_normal(0, 0, upper ? 1 : -1);
  const Vector3 side_normal(border.normal.x(), border.normal.y(), 0);
  if (border.signed_distance_m <= face_distance && border.signed_distance_m <= 0) {
    return {face_distance, Vector3(p.x(), p.y(), face_z), face_normal};
  }
  if (face_distance <= 0) {
    return {border.signed_distance_m, Vector3(border.nearest.x(), border.nearest.y(), p.z()),
            side_normal};
  }
  const double distance = std::hypot(border.signed_distance_m, face_distance);
  const Vector3 normal =
      distance > kDistanceRoundoff * SizeOf(plate)
          ? Vector3((border.signed_distance_m * side_normal + face_distance * face_normal) /
                    distance)
          : face_normal;
  return {distance, Vector3(border.nearest.x(), border.nearest.y(), face_z), normal};
}

SurfacePoint NearestSurfacePoint(const Shape& shape, const Vector3& p) {
  return std::visit([&p](const auto& s) { return NearestSurfacePoint(s, p); }, shape);
}

}  // namespace cwm
