#include "collision/geometry/validation.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "collision/geometry/triangle.h"

namespace cwm {
namespace {

using MaybeViolation = std::optional<Violation>;

std::string Text(double value) {
  if (std::isnan(value)) return "nan";
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%.9g", value);
  return buffer;
}

std::string Indexed(const char* name, std::size_t index) {
  return std::string(name) + "[" + std::to_string(index) + "]";
}

MaybeViolation CheckDimension(const char* field, double value) {
  if (!(value > 0) || !std::isfinite(value)) {
    return Violation{field, Text(value), "must be positive and finite"};
  }
  if (value < kMinDimension_m) return Violation{field, Text(value), "must be at least 1e-9 m"};
  if (value > kMaxCoordinate_m) return Violation{field, Text(value), "must be at most 1e6 m"};
  return std::nullopt;
}

MaybeViolation CheckCoordinate(const std::string& field, double value) {
  if (!std::isfinite(value)) return Violation{field, Text(value), "must be finite"};
  if (std::abs(value) > kMaxCoordinate_m) {
    return Violation{field, Text(value), "must be within 1e6 m of the origin"};
  }
  return std::nullopt;
}

MaybeViolation CheckRing(const std::string& field, const Polygon& ring) {
  if (ring.size() < 3) {
    return Violation{field, std::to_string(ring.size()) + " vertices",
                     "must have at least 3 vertices"};
  }
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const std::string vertex = Indexed(field.c_str(), i);
    if (auto v = CheckCoordinate(vertex + ".x", ring[i].x())) return v;
    if (auto v = CheckCoordinate(vertex + ".y", ring[i].y())) return v;
  }
  if (!IsSimple(ring)) {
    return Violation{field, std::to_string(ring.size()) + " vertices",
                     "must be a simple polygon: no edge may cross or touch another, nor have zero "
                     "length"};
  }
  return std::nullopt;
}

MaybeViolation CheckVertex(const Vector3& p, std::size_t index) {
  if (p.allFinite() && p.cwiseAbs().maxCoeff() <= kMaxCoordinate_m) return std::nullopt;
  const std::string vertex = Indexed("vertices", index);
  for (int axis = 0; axis < 3; ++axis) {
    const char* const component[] = {".x", ".y", ".z"};
    if (auto v = CheckCoordinate(vertex + component[axis], p[axis])) return v;
  }
  return std::nullopt;
}

MaybeViolation CheckTriangle(const TriangleMesh& mesh, std::size_t index) {
  const TriangleMesh::Triangle& t = mesh.triangles[index];
  const auto largest = static_cast<std::size_t>(std::max({t[0], t[1], t[2]}));
  const bool uses_one_twice = t[0] == t[1] || t[1] == t[2] || t[2] == t[0];
  if (largest < mesh.vertices.size() && !uses_one_twice) return std::nullopt;
  const std::string value =
      std::to_string(t[0]) + " " + std::to_string(t[1]) + " " + std::to_string(t[2]);
  for (const std::uint32_t i : t) {
    if (i < mesh.vertices.size()) continue;
    return Violation{Indexed("triangles", index), value,
                     "must index one of the " + std::to_string(mesh.vertices.size()) + " vertices"};
  }
  return Violation{Indexed("triangles", index), value, "must use three different vertices"};
}

// The smallest height of a triangle.
double MinHeight(const Vector3& a, const Vector3& b, const Vector3& c) {
  const double longest = std::max({(b - a).norm(), (c - b).norm(), (a - c).norm()});
  return longest > 0 ? (b - a).cross(c - a).norm() / longest : 0;
}

// How far a vertex of a hull may lie in front of a triangle of the given height, in metres.
// derived: single-precision vertices are off by 2^-24 of the extent. The plane of a triangle turns
// by that over its height, which moves the far end of the hull by the product with the extent.
// Twice that because both ends are rounded.
double PlaneTolerance(double extent, double height) {
  constexpr double kRounding = 0x1p-23;
  return kRounding * extent * (1.0 + extent / height);
}

MaybeViolation CheckConvexity(const TriangleMesh& hull, WorkCounter* work) {
  constexpr std::size_t kVerticesPerStep = 16;
  Eigen::AlignedBox3d bounds;
  for (const Vector3& p : hull.vertices) bounds.extend(p);
  const double extent = bounds.diagonal().norm();
  for (std::size_t i = 0; i < hull.triangles.size(); ++i) {
    if (MustEnd(work, 1 + hull.vertices.size() / kVerticesPerStep)) break;
    const TriangleMesh::Triangle& t = hull.triangles[i];
    const Vector3 &a = hull.vertices[t[0]], &b = hull.vertices[t[1]], &c = hull.vertices[t[2]];
    const double height = MinHeight(a, b, c);
    if (!(height > 0)) continue;  // a triangle without area defines no plane
    const double tolerance = PlaneTolerance(extent, height);
    const Vector3 normal = TriangleNormal(a, b, c);
    for (const Vector3& p : hull.vertices) {
      const double beyond = normal.dot(p - a);
      if (beyond <= tolerance) continue;
      return Violation{Indexed("triangles", i), "a vertex " + Text(beyond) + " m in front of it",
                       "must have every vertex of the convex hull behind it"};
    }
  }
  return std::nullopt;
}

MaybeViolation CheckHull(const TriangleMesh& hull, WorkCounter* work) {
  if (auto v = FindViolation(hull, work)) return v;
  const std::string count = std::to_string(hull.triangles.size()) + " triangles";
  if (hull.triangles.size() > static_cast<std::size_t>(kMaxHullTriangles)) {
    return Violation{"hull", count, "must have at most 16384 triangles; send a mesh instead"};
  }
  if (!IsWatertightByIndex(hull, work)) {
    return Violation{"hull", count, "must be watertight: each edge shared by two triangles"};
  }
  const double volume_m3 = SignedVolume_m3(hull, work);
  if (!(volume_m3 > 0)) {
    return Violation{"hull", Text(volume_m3) + " m^3",
                     "must be wound counter-clockwise seen from outside and hold a volume"};
  }
  return CheckConvexity(hull, work);
}

struct Finder {
  WorkCounter* work = nullptr;

  MaybeViolation operator()(const Sphere& s) const {
    return CheckDimension("radius_m", s.radius_m);
  }
  MaybeViolation operator()(const Box& s) const {
    if (auto v = CheckDimension("size_x_m", s.size_m.x())) return v;
    if (auto v = CheckDimension("size_y_m", s.size_m.y())) return v;
    return CheckDimension("size_z_m", s.size_m.z());
  }
  MaybeViolation operator()(const Cylinder& s) const {
    if (auto v = CheckDimension("radius_m", s.radius_m)) return v;
    return CheckDimension("length_m", s.length_m);
  }
  MaybeViolation operator()(const Cone& s) const {
    if (s.radius_bottom_m == 0 && s.radius_top_m == 0) {
      return Violation{"radius_bottom_m", "0", "must be positive where radius_top_m is 0"};
    }
    if (s.radius_bottom_m != 0) {
      if (auto v = CheckDimension("radius_bottom_m", s.radius_bottom_m)) return v;
    }
    if (s.radius_top_m != 0) {
      if (auto v = CheckDimension("radius_top_m", s.radius_top_m)) return v;
    }
    return CheckDimension("length_m", s.length_m);
  }
  MaybeViolation operator()(const Capsule& s) const {
    if (auto v = CheckDimension("radius_m", s.radius_m)) return v;
    return CheckDimension("length_m", s.length_m);
  }
  MaybeViolation operator()(const HalfSpace&) const { return std::nullopt; }
  MaybeViolation operator()(const Plate& s) const {
    if (auto v = CheckDimension("thickness_m", s.thickness_m)) return v;
    std::size_t vertices = s.outline.size();
    for (const Polygon& hole : s.holes) vertices += hole.size();
    if (vertices > static_cast<std::size_t>(kMaxPlateVertices)) {
      return Violation{"outline", std::to_string(vertices) + " vertices",
                       "must have at most 4096 vertices together with the holes; send a mesh "
                       "instead"};
    }
    if (auto v = CheckRing("outline", s.outline)) return v;
    for (std::size_t i = 0; i < s.holes.size(); ++i) {
      if (auto v = CheckRing(Indexed("holes", i), s.holes[i])) return v;
    }
    if (IsSimpleRegion(s.outline, s.holes)) return std::nullopt;
    return Violation{"holes", std::to_string(s.holes.size()) + " holes",
                     "must lie strictly inside the outline and apart from each other"};
  }
  MaybeViolation operator()(const Convex& s) const {
    if (s.hull == nullptr) return Violation{"hull", "absent", "must be given"};
    return CheckHull(*s.hull, work);
  }
  MaybeViolation operator()(const Mesh& s) const {
    if (s.mesh == nullptr) return Violation{"mesh", "absent", "must be given"};
    return FindViolation(*s.mesh, work);
  }
};

}  // namespace

MaybeViolation FindViolation(const Shape& shape, WorkCounter* work) {
  return std::visit(Finder{work}, shape);
}

MaybeViolation FindViolation(const TriangleMesh& mesh, WorkCounter* work) {
  MaybeViolation found;
  ForEachBlock(mesh.vertices.size(), work, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last && !found; ++i) found = CheckVertex(mesh.vertices[i], i);
  });
  if (found) return found;
  if (mesh.triangles.empty()) {
    return Violation{"triangles", "0 triangles", "must have at least one triangle"};
  }
  ForEachBlock(mesh.triangles.size(), work, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last && !found; ++i) found = CheckTriangle(mesh, i);
  });
  return found;
}

}  // namespace cwm
