#include "collision/geometry/tessellate.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "collision/geometry/vessel_shell.h"

namespace cwm {
namespace {

constexpr double kPi = std::numbers::pi;

// The number of segments of a full circle whose chords stay within `deviation_m` of the arc, by the
// sagitta r (1 - cos(pi / n)).
int SegmentsFor(double radius_m, double deviation_m) {
  const double cosine = 1.0 - deviation_m / radius_m;
  if (!(cosine > 0)) return kMinSegments;
  const double segments = std::ceil(kPi / std::acos(std::min(cosine, 1.0 - 1e-9)));
  return static_cast<int>(std::clamp(segments, double{kMinSegments}, double{kMaxSegments}));
}

// The largest distance of the chords from the arc if the circle has that many segments.
double Sagitta_m(double radius_m, int segments) {
  return radius_m * (1.0 - std::cos(kPi / segments));
}

// The number of segments for the caps of a capsule. The deviations in both directions of curvature
// add up, so each gets half.
int CapSegments(double radius_m, double deviation_m) {
  return SegmentsFor(radius_m, 0.5 * deviation_m);
}

double WidestRadius_m(const Cone& s) { return std::max(s.radius_bottom_m, s.radius_top_m); }

// The surface swept by a profile (radial, z) with the solid on its left. Its first and its last
// point, and no others, lie on the axis: the bottom and the top of the solid, or the floor of a
// vessel.
TriangleMesh Revolve(const std::vector<Vector2>& profile, int segments) {
  TriangleMesh mesh;
  const auto count = static_cast<std::uint32_t>(segments);
  const auto rings = static_cast<std::uint32_t>(profile.size()) - 2;
  mesh.vertices.emplace_back(0, 0, profile.front().y());
  for (std::uint32_t ring = 1; ring <= rings; ++ring) {
    for (std::uint32_t i = 0; i < count; ++i) {
      const double angle_rad = 2.0 * kPi * i / count;
      mesh.vertices.emplace_back(profile[ring].x() * std::cos(angle_rad),
                                 profile[ring].x() * std::sin(angle_rad), profile[ring].y());
    }
  }
  mesh.vertices.emplace_back(0, 0, profile.back().y());
  const std::uint32_t top = 1 + rings * count;
  const auto at = [count](std::uint32_t ring, std::uint32_t i) {
    return 1 + ring * count + i % count;
  };
  for (std::uint32_t i = 0; i < count; ++i) {
    mesh.triangles.push_back({0, at(0, i + 1), at(0, i)});
    for (std::uint32_t ring = 0; ring + 1 < rings; ++ring) {
      mesh.triangles.push_back({at(ring, i), at(ring, i + 1), at(ring + 1, i + 1)});
      mesh.triangles.push_back({at(ring, i), at(ring + 1, i + 1), at(ring + 1, i)});
    }
    mesh.triangles.push_back({top, at(rings - 1, i), at(rings - 1, i + 1)});
  }
  return mesh;
}

// Appends an arc about (0, centre_z) from latitude `from_rad` to latitude `to_rad`, both ends
// included; the poles get a radius of exactly zero.
void AppendArc(double radius_m, double centre_z, double from_rad, double to_rad, int steps,
               std::vector<Vector2>& profile) {
  for (int i = 0; i <= steps; ++i) {
    const double latitude_rad = from_rad + (to_rad - from_rad) * i / steps;
    const bool pole = std::abs(std::abs(latitude_rad) - 0.5 * kPi) < 1e-9;
    profile.emplace_back(pole ? 0 : radius_m * std::cos(latitude_rad),
                         centre_z + radius_m * std::sin(latitude_rad));
  }
}

TriangleMesh BoxMesh(const Vector3& low, const Vector3& high) {
  TriangleMesh mesh;
  for (int i = 0; i < 8; ++i) {
    mesh.vertices.emplace_back(i & 1 ? high.x() : low.x(), i & 2 ? high.y() : low.y(),
                               i & 4 ? high.z() : low.z());
  }
  mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return mesh;
}

// Appends the walls below a ring of top vertices [first, first + size); the index of the bottom
// vertex is that of the top vertex plus `offset`.
void AppendWalls(const Polygon& ring, bool is_hole, std::uint32_t first, std::uint32_t offset,
                 TriangleMesh& mesh) {
  const auto size = static_cast<std::uint32_t>(ring.size());
  const bool solid_on_left = (SignedArea_m2(ring) > 0) != is_hole;
  for (std::uint32_t i = 0; i < size; ++i) {
    std::uint32_t a = first + i, b = first + (i + 1) % size;
    if (!solid_on_left) std::swap(a, b);
    mesh.triangles.push_back({a, a + offset, b + offset});
    mesh.triangles.push_back({a, b + offset, b});
  }
}

struct Tessellator {
  double deviation_m;

  TriangleMesh operator()(const Sphere& s) const {
    return (*this)(Capsule{.radius_m = s.radius_m, .length_m = 0});
  }
  TriangleMesh operator()(const Box& s) const { return BoxMesh(-0.5 * s.size_m, 0.5 * s.size_m); }
  TriangleMesh operator()(const Cylinder& s) const {
    return (*this)(Cone{s.radius_m, s.radius_m, s.length_m});
  }
  TriangleMesh operator()(const Cone& s) const {
    const double half = 0.5 * s.length_m;
    std::vector<Vector2> profile = {{0, -half}};
    if (s.radius_bottom_m > 0) profile.emplace_back(s.radius_bottom_m, -half);
    if (s.radius_top_m > 0) profile.emplace_back(s.radius_top_m, half);
    profile.emplace_back(0, half);
    return Revolve(profile, SegmentsFor(WidestRadius_m(s), deviation_m));
  }
  TriangleMesh operator()(const Capsule& s) const {
    const int segments = CapSegments(s.radius_m, deviation_m);
    const int steps = (segments + 3) / 4;
    const double half = 0.5 * s.length_m;
    std::vector<Vector2> profile;
    AppendArc(s.radius_m, -half, -0.5 * kPi, 0, steps, profile);
    if (half == 0) profile.pop_back();  // one equator, not two
    AppendArc(s.radius_m, half, 0, 0.5 * kPi, steps, profile);
    return Revolve(profile, segments);
  }
  TriangleMesh operator()(const HalfSpace&) const {
    return BoxMesh(Vector3(-10, -10, -1), Vector3(10, 10, 0));
  }
  TriangleMesh operator()(const Plate& s) const {
    TriangleMesh mesh;
    const auto append_ring = [&mesh](const Polygon& ring, double z) {
      for (const Vector2& p : ring) mesh.vertices.emplace_back(p.x(), p.y(), z);
    };
    for (const double z : {0.0, -s.thickness_m}) {
      append_ring(s.outline, z);
      for (const Polygon& hole : s.holes) append_ring(hole, z);
    }
    const auto offset = static_cast<std::uint32_t>(mesh.vertices.size() / 2);
    for (const std::array<int, 3>& t : TriangulateIndices(s.outline, s.holes)) {
      const auto a = static_cast<std::uint32_t>(t[0]);
      const auto b = static_cast<std::uint32_t>(t[1]);
      const auto c = static_cast<std::uint32_t>(t[2]);
      mesh.triangles.push_back({a, b, c});
      mesh.triangles.push_back({a + offset, c + offset, b + offset});
    }
    std::uint32_t first = 0;
    AppendWalls(s.outline, /*is_hole=*/false, first, offset, mesh);
    first += static_cast<std::uint32_t>(s.outline.size());
    for (const Polygon& hole : s.holes) {
      AppendWalls(hole, /*is_hole=*/true, first, offset, mesh);
      first += static_cast<std::uint32_t>(hole.size());
    }
    return mesh;
  }
  TriangleMesh operator()(const Convex& s) const { return *s.hull; }
  TriangleMesh operator()(const Mesh& s) const { return *s.mesh; }
};

struct Deviation {
  double deviation_m;

  double operator()(const Sphere& s) const { return OfCaps(s.radius_m); }
  double operator()(const Box&) const { return 0; }
  double operator()(const Cylinder& s) const {
    return (*this)(Cone{s.radius_m, s.radius_m, s.length_m});
  }
  double operator()(const Cone& s) const {
    const double radius_m = WidestRadius_m(s);
    return Sagitta_m(radius_m, SegmentsFor(radius_m, deviation_m));
  }
  double operator()(const Capsule& s) const { return OfCaps(s.radius_m); }
  double operator()(const HalfSpace&) const { return 0; }
  double operator()(const Plate&) const { return 0; }
  double operator()(const Convex&) const { return 0; }
  double operator()(const Mesh&) const { return 0; }

  double OfCaps(double radius_m) const {
    return 2.0 * Sagitta_m(radius_m, CapSegments(radius_m, deviation_m));
  }
};

}  // namespace

TriangleMesh Tessellate(const Shape& shape, double max_deviation_m) {
  return std::visit(Tessellator{max_deviation_m}, shape);
}

TriangleMesh Tessellate(const VesselShell& shell, double max_deviation_m) {
  std::vector<Vector2> profile = {{0, shell.outer.front().y()}};
  profile.insert(profile.end(), shell.outer.begin(), shell.outer.end());
  profile.insert(profile.end(), shell.inner.begin(), shell.inner.end());
  double max_radius_m = 0;
  for (const Vector2& point : profile) max_radius_m = std::max(max_radius_m, point.x());
  return Revolve(profile, SegmentsFor(max_radius_m, max_deviation_m));
}

double DeviationBound_m(const Shape& shape, double max_deviation_m) {
  return std::visit(Deviation{max_deviation_m}, shape);
}

}  // namespace cwm
