#include "collision/kernels/contact_feature.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <optional>
#include <span>

#include "collision/geometry/polygon.h"
#include "collision/geometry/triangle.h"

namespace cwm::collision {
namespace {

// chosen: corners of the polygon inscribed in a disc, which covers 97 % of its area.
constexpr int kDiscCorners = 16;

// If the component of a unit direction across an axis is shorter than this, it is only rounding and
// has no direction.
constexpr double kNoDirection = 1e-9;

// Share of the extent within which corners of a hull count as lying on a plane. derived: four
// roundings of the single precision in which clients send hulls.
constexpr double kCoplanarShare = 2.5e-7;

ContactFeature Point(const Vector3& p) {
  ContactFeature point;
  point.Add(p);
  return point;
}

ContactFeature Line(const Vector3& p, const Vector3& q) {
  ContactFeature line;
  line.Add(p);
  line.Add(q);
  return line;
}

ContactFeature FeatureOf(const Box& box, const Vector3& d) {
  // The start is always the same corner of the box, so that the feature rotates with the box.
  Vector3 corner = 0.5 * box.size_m;
  std::array<int, 3> free = {};
  int count = 0;
  Vector3 normal = Vector3::Zero();
  for (int axis = 0; axis < 3; ++axis) {
    if (std::abs(d[axis]) <= kMaxTilt) {
      free[static_cast<std::size_t>(count++)] = axis;
    } else {
      corner[axis] = std::copysign(corner[axis], d[axis]);
      normal[axis] = std::copysign(1.0, d[axis]);
    }
  }
  ContactFeature feature = Point(corner);
  if (count == 0) return feature;
  const auto mirrored = [](Vector3 p, int axis) {
    p[axis] = -p[axis];
    return p;
  };
  const Vector3 second = mirrored(corner, free[0]);
  feature.Add(second);
  if (count == 1) return feature;
  feature.Add(mirrored(second, free[1]));
  feature.Add(mirrored(corner, free[1]));
  feature.normal = normal;
  return feature;
}

// The disc at z = z_m, facing to the side of `d`, as a polygon. One of its corners lies in the
// direction of d, so that the deepest point of a tilted disc is a corner of the polygon.
ContactFeature Disc(double radius_m, double z_m, const Vector3& d) {
  ContactFeature disc;
  const double begin = d.head<2>().norm() > kNoDirection ? std::atan2(d.y(), d.x()) : 0;
  for (int i = 0; i < kDiscCorners; ++i) {
    const double angle = begin + 2 * std::numbers::pi * i / kDiscCorners;
    disc.Add({radius_m * std::cos(angle), radius_m * std::sin(angle), z_m});
  }
  disc.normal = Vector3(0, 0, std::copysign(1.0, d.z()));
  return disc;
}

ContactFeature FeatureOf(const Cone& cone, const Vector3& d) {
  const double half = 0.5 * cone.length_m, radial = d.head<2>().norm();
  const Vector3 foremost = SupportPoint(cone, d);
  const double cap_m = d.z() > 0 ? cone.radius_top_m : cone.radius_bottom_m;
  const bool is_cap = (foremost.z() > 0) == (d.z() > 0);
  if (radial <= kMaxTilt && is_cap && cap_m > 0) return Disc(cap_m, foremost.z(), d);
  if (radial <= kNoDirection) return Point(foremost);
  // The outward normal of the side, as (radial, axial).
  const Vector2 side =
      Vector2(cone.length_m, cone.radius_bottom_m - cone.radius_top_m).normalized();
  const double sine = radial * side.y() - d.z() * side.x();
  const double cosine = radial * side.x() + d.z() * side.y();
  if (std::abs(sine) > kMaxTilt || cosine < 0) return Point(foremost);
  const Vector2 outward = d.head<2>() / radial;
  const auto on_rim = [&](double radius_m, double z_m) {
    return Vector3(radius_m * outward.x(), radius_m * outward.y(), z_m);
  };
  return Line(on_rim(cone.radius_bottom_m, -half), on_rim(cone.radius_top_m, half));
}

ContactFeature FeatureOf(const Cylinder& cylinder, const Vector3& d) {
  return FeatureOf(Cone{cylinder.radius_m, cylinder.radius_m, cylinder.length_m}, d);
}

ContactFeature CapsuleFeature(double half_length_m, double radius_m, const Vector3& d) {
  const double radial = d.head<2>().norm();
  if (std::abs(d.z()) > kMaxTilt || half_length_m == 0) {
    return Point(Vector3(0, 0, std::copysign(half_length_m, d.z())) + radius_m * d);
  }
  const Vector3 off = Vector3(d.x(), d.y(), 0) * (radius_m / radial);
  return Line(off - Vector3(0, 0, half_length_m), off + Vector3(0, 0, half_length_m));
}

// The polygon itself, or if it has too many corners, those farthest in kMaxCorners directions.
Polygon Thinned(const Polygon& polygon) {
  if (polygon.size() <= ContactFeature::kMaxCorners) return polygon;
  Polygon thinned;
  std::size_t last = polygon.size();
  for (int i = 0; i < ContactFeature::kMaxCorners; ++i) {
    const double angle = 2 * std::numbers::pi * i / ContactFeature::kMaxCorners;
    const Vector2 direction(std::cos(angle), std::sin(angle));
    const auto farthest = std::max_element(
        polygon.begin(), polygon.end(),
        [&](const Vector2& p, const Vector2& q) { return p.dot(direction) < q.dot(direction); });
    const auto index = static_cast<std::size_t>(farthest - polygon.begin());
    if (index == last || (!thinned.empty() && *farthest == thinned.front())) continue;
    thinned.push_back(*farthest);
    last = index;
  }
  return thinned;
}

// The foremost feature of a plate's piece. `vertices` are the corners of a polygon at z = 0,
// counter-clockwise, followed by those at the bottom.
ContactFeature PrismFeature(std::span<const Vector3> vertices, const Vector3& d) {
  const std::size_t sides = vertices.size() / 2;
  const std::span<const Vector3> rim = vertices.subspan(d.z() > 0 ? 0 : sides, sides);
  const std::span<const Vector3> other = vertices.subspan(d.z() > 0 ? sides : 0, sides);
  const double radial = d.head<2>().norm();
  if (radial <= kMaxTilt) {
    Polygon polygon;
    for (const Vector3& v : rim) polygon.emplace_back(v.x(), v.y());
    ContactFeature cap;
    for (const Vector2& p : Thinned(polygon)) cap.Add({p.x(), p.y(), rim.front().z()});
    cap.normal = Vector3(0, 0, std::copysign(1.0, d.z()));
    return cap;
  }
  const Vector2 beside = d.head<2>() / radial;
  std::size_t best = 0;
  double max_cosine = -1;
  Vector2 outward = Vector2::Zero();
  for (std::size_t i = 0; i < sides; ++i) {
    const Vector3 along = rim[(i + 1) % sides] - rim[i];
    const Vector2 normal = Vector2(along.y(), -along.x()).normalized();
    if (!(normal.dot(beside) > max_cosine)) continue;
    max_cosine = normal.dot(beside);
    outward = normal;
    best = i;
  }
  const std::size_t next = (best + 1) % sides;
  const bool is_upright = std::abs(d.z()) <= kMaxTilt;
  const double sine = beside.x() * outward.y() - beside.y() * outward.x();
  if (max_cosine > 0 && std::abs(sine) <= kMaxTilt) {
    if (!is_upright) return Line(rim[best], rim[next]);
    ContactFeature side = Line(rim[best], rim[next]);
    side.Add(other[next]);
    side.Add(other[best]);
    side.normal = Vector3(outward.x(), outward.y(), 0);
    return side;
  }
  const auto foremost = static_cast<std::size_t>(
      std::max_element(rim.begin(), rim.end(),
                       [&](const Vector3& p, const Vector3& q) { return p.dot(d) < q.dot(d); }) -
      rim.begin());
  return is_upright ? Line(rim[foremost], other[foremost]) : Point(rim[foremost]);
}

// The face of a hull that lies in the plane through `on_face` with the given normal.
ContactFeature HullFace(const TriangleMesh& hull, const Vector3& on_face, const Vector3& normal,
                        double tolerance_m) {
  const Matrix3 R = BasisFromZ(normal);
  std::vector<Vector2> points;
  for (const Vector3& v : hull.vertices) {
    const Vector3 offset = v - on_face;
    if (std::abs(normal.dot(offset)) > tolerance_m) continue;
    points.emplace_back(R.col(0).dot(offset), R.col(1).dot(offset));
  }
  ContactFeature face;
  for (const Vector2& p : Thinned(ConvexHull(std::move(points)))) {
    face.Add(on_face + R.col(0) * p.x() + R.col(1) * p.y());
  }
  face.normal = normal;
  return face;
}

// The foremost feature of a hull: among the faces and edges at the foremost corner the face that
// leans least, else the edge that leans least, else the corner.
ContactFeature HullFeature(const TriangleMesh& hull, double extent_m, const Vector3& d) {
  std::uint32_t foremost = 0;
  for (std::uint32_t i = 1; i < hull.vertices.size(); ++i) {
    if (hull.vertices[i].dot(d) > hull.vertices[foremost].dot(d)) foremost = i;
  }
  const Vector3& corner = hull.vertices[foremost];
  Vector3 face_normal = Vector3::Zero();
  double steepest = -1;  // largest rise of an edge along d, per length; never above 0
  Vector3 end = corner;
  for (const auto& triangle : hull.triangles) {
    if (std::find(triangle.begin(), triangle.end(), foremost) == triangle.end()) continue;
    const auto& [a, b, c] = triangle;
    const auto normal = ReliableNormal(hull.vertices[a], hull.vertices[b], hull.vertices[c]);
    if (normal && normal->dot(d) > face_normal.dot(d)) face_normal = *normal;
    for (const std::uint32_t k : triangle) {
      const Vector3 along = hull.vertices[k] - corner;
      if (k == foremost || !(along.dot(d) > steepest * along.norm())) continue;
      steepest = along.dot(d) / along.norm();
      end = hull.vertices[k];
    }
  }
  if (face_normal.cross(d).norm() <= kMaxTilt && !face_normal.isZero(0)) {
    ContactFeature face = HullFace(hull, corner, face_normal, kCoplanarShare * extent_m);
    if (face.count > 2) return face;
  }
  return steepest >= -kMaxTilt ? Line(corner, end) : Point(corner);
}

}  // namespace

ContactFeature SupportFeature(const ExactGeometry& shape, std::size_t piece, const Vector3& d) {
  const ConvexCore& core = shape.pieces()[piece];
  if (const auto* box = std::get_if<Box>(&core.core)) return FeatureOf(*box, d);
  if (const auto* cylinder = std::get_if<Cylinder>(&core.core)) return FeatureOf(*cylinder, d);
  if (const auto* cone = std::get_if<Cone>(&core.core)) return FeatureOf(*cone, d);
  if (const auto* segment = std::get_if<SegmentCore>(&core.core)) {
    return CapsuleFeature(segment->half_length_m, core.radius_m, d);
  }
  if (const auto* convex = std::get_if<Convex>(&shape.shape())) {
    return HullFeature(*convex->hull, core.extent_m, d);
  }
  if (const auto* prism = std::get_if<VertexCore>(&core.core)) {
    return PrismFeature(prism->vertices, d);
  }
  return Point(core.radius_m * d);
}

std::optional<ContactFeature> SupportFeature(const TriangleCorners& triangle, FreeSide free_side,
                                             const Vector3& d) {
  const auto& c = triangle.corners;
  const auto sure = ReliableNormal(c[0], c[1], c[2]);
  if (!sure) return std::nullopt;  // a needle: its neighbours have the same features
  const double along = sure->dot(d);
  if (along < 0 && free_side == FreeSide::kNormalSide) return std::nullopt;
  if (sure->cross(d).norm() <= kMaxTilt) {
    ContactFeature face;
    for (const Vector3& corner : c) face.Add(corner);
    face.normal = along < 0 ? -*sure : *sure;
    return face;
  }
  std::size_t top = 0;
  for (std::size_t i = 1; i < 3; ++i) {
    if (c[i].dot(d) > c[top].dot(d)) top = i;
  }
  for (std::size_t i = 0; i < 3; ++i) {
    const Vector3 edge = c[i] - c[top];
    if (i != top && -edge.dot(d) <= kMaxTilt * edge.norm()) return Line(c[top], c[i]);
  }
  return Point(c[top]);
}

}  // namespace cwm::collision
