#include "collision/engines/convex_pieces.h"

#include <cmath>
#include <numbers>

namespace cwm::collision {
namespace {

// Sides of the polygon around a disc: 64 keep a cup of 4 cm radius within 0.05 mm and stay cheap
// for a support function that walks the edges.
constexpr int kSideCount = 64;

// Circumradius of the polygon over the radius of the disc that it touches.
const double kCircumradius = 1.0 / std::cos(std::numbers::pi / kSideCount);

void AppendRing(double radius_m, double z_m, std::vector<Vector3>& points) {
  if (radius_m == 0) {
    points.emplace_back(0, 0, z_m);
    return;
  }
  for (int i = 0; i < kSideCount; ++i) {
    const double angle = 2 * std::numbers::pi * i / kSideCount;
    points.emplace_back(kCircumradius * radius_m * std::cos(angle),
                        kCircumradius * radius_m * std::sin(angle), z_m);
  }
}

}  // namespace

ConvexPieceSet CircumscribedPieces(const Cone& cone) {
  std::vector<Vector3> points;
  AppendRing(cone.radius_bottom_m, -0.5 * cone.length_m, points);
  AppendRing(cone.radius_top_m, 0.5 * cone.length_m, points);
  const double widest_m = std::max(cone.radius_bottom_m, cone.radius_top_m);
  return {.hulls = {ConvexHull3(points)}, .bound_m = (kCircumradius - 1) * widest_m};
}

ConvexPieceSet CircumscribedPieces(const Plate& plate) {
  ConvexPieceSet pieces;
  for (const Polygon& polygon : ConvexPieces(plate.outline, plate.holes)) {
    std::vector<Vector3> points;
    for (const Vector2& p : polygon) {
      points.emplace_back(p.x(), p.y(), 0);
      points.emplace_back(p.x(), p.y(), -plate.thickness_m);
    }
    TriangleMesh hull = ConvexHull3(points);
    if (!hull.triangles.empty()) pieces.hulls.push_back(std::move(hull));
  }
  return pieces;
}

}  // namespace cwm::collision
