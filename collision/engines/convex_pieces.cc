#include "collision/engines/convex_pieces.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace cwm::collision {
namespace {

// chosen: sides of the polygon around a disc. 64 sides keep a cup of 4 cm radius within 0.05 mm and
// stay cheap for a support function that walks the edges.
constexpr int kSideCount = 64;

// The ratio of the polygon's circumradius to the radius of the disc that it touches.
const double kCircumradius = 1.0 / std::cos(std::numbers::pi / kSideCount);

// The corners of the regular polygon around a disc, or a single point if the radius is 0.
std::vector<Vector3> Ring(double radius_m, double z_m) {
  if (radius_m == 0) return {Vector3(0, 0, z_m)};
  std::vector<Vector3> points;
  for (int i = 0; i < kSideCount; ++i) {
    const double angle = 2 * std::numbers::pi * i / kSideCount;
    points.emplace_back(kCircumradius * radius_m * std::cos(angle),
                        kCircumradius * radius_m * std::sin(angle), z_m);
  }
  return points;
}

// The solid between two horizontal convex rings with equally many points, or between a ring and one
// point, both counter-clockwise seen from above. It is built corner by corner because a convex hull
// search fails on a body that is a millionth as high as it is wide.
TriangleMesh Between(const std::vector<Vector3>& lower, const std::vector<Vector3>& upper) {
  TriangleMesh mesh{.vertices = lower, .triangles = {}};
  mesh.vertices.insert(mesh.vertices.end(), upper.begin(), upper.end());
  const auto below = static_cast<std::uint32_t>(lower.size());
  const auto above = static_cast<std::uint32_t>(upper.size());
  for (std::uint32_t i = 2; i < below; ++i) mesh.triangles.push_back({0, i, i - 1});
  for (std::uint32_t i = 2; i < above; ++i) {
    mesh.triangles.push_back({below, below + i - 1, below + i});
  }
  for (std::uint32_t i = 0; i < std::max(below, above); ++i) {
    const std::uint32_t a = i % below, b = (i + 1) % below;
    const std::uint32_t c = below + i % above, d = below + (i + 1) % above;
    if (a != b) mesh.triangles.push_back({a, b, d});
    if (c != d) mesh.triangles.push_back({a, d, c});
  }
  return mesh;
}

std::vector<Vector3> AtHeight(const Polygon& polygon, double z_m) {
  std::vector<Vector3> points;
  points.reserve(polygon.size());
  for (const Vector2& p : polygon) points.emplace_back(p.x(), p.y(), z_m);
  return points;
}

}  // namespace

ConvexPieceSet CircumscribedPieces(const Cone& cone) {
  const double max_radius_m = std::max(cone.radius_bottom_m, cone.radius_top_m);
  return {.hulls = {Between(Ring(cone.radius_bottom_m, -0.5 * cone.length_m),
                            Ring(cone.radius_top_m, 0.5 * cone.length_m))},
          .bound_m = (kCircumradius - 1) * max_radius_m};
}

ConvexPieceSet CircumscribedPieces(const Plate& plate) {
  ConvexPieceSet pieces;
  for (const Polygon& polygon : ConvexPieces(plate.outline, plate.holes)) {
    pieces.hulls.push_back(Between(AtHeight(polygon, -plate.thickness_m), AtHeight(polygon, 0)));
  }
  return pieces;
}

}  // namespace cwm::collision
