#include "collision/kernels/inner_hull.h"

#include <algorithm>
#include <cstddef>

#include "collision/kernels/vertex_lanes.h"

namespace cwm::collision {
namespace {

// Number of planes compared in one step of a WorkCounter.
constexpr std::size_t kPlanesPerStep = 32;

}  // namespace

std::vector<Vector3> PolarOf(const TriangleMesh& hull, const Vector3& centre) {
  std::vector<Vector3> spokes = hull.vertices;
  for (Vector3& spoke : spokes) spoke -= centre;
  const VertexLanes ends(spokes);
  std::vector<Vector3> polar;
  polar.reserve(hull.triangles.size());
  for (const auto& [a, b, c] : hull.triangles) {
    const Vector3& corner = hull.vertices[a];
    const Vector3 normal = (hull.vertices[b] - corner).cross(hull.vertices[c] - corner);
    const double height = normal.dot(spokes[ends.Farthest(normal)]);
    if (height > 0) polar.push_back(normal / height);
  }
  return polar;
}

std::vector<double> PlaneScales(const std::vector<Vector3>& polar, const Vector3& centre,
                                const TriangleTree& tree, double min_scale, WorkCounter* work) {
  const VertexLanes lanes(polar);
  std::vector<double> scales(polar.size(), 1);
  for (const TriangleCorners& triangle : tree.triangles()) {
    const auto& [a, b, c] = triangle.corners;
    const Vector3 p = a - centre, q = b - centre, r = c - centre;
    const std::size_t nearest = lanes.Farthest(p + q + r);
    const Vector3& plane = polar[nearest];
    double& scale = scales[nearest];
    scale = std::min({scale, plane.dot(p), plane.dot(q), plane.dot(r)});
    if (scale < min_scale || MustEnd(work, 1 + polar.size() / kPlanesPerStep)) break;
  }
  return scales;
}

// The corners of a solid are the planes of the hull of its polar set.
std::vector<Vector3> CornersBehind(const std::vector<Vector3>& polar,
                                   const std::vector<double>& scales, const Vector3& centre,
                                   WorkCounter* work) {
  std::vector<Vector3> shrunk;
  shrunk.reserve(polar.size());
  for (std::size_t k = 0; k < polar.size(); ++k) shrunk.push_back(polar[k] / scales[k]);
  const TriangleMesh around = ConvexHull3(shrunk, work);
  if (HasEnded(work) || around.triangles.empty()) return {};
  const VertexLanes planes(shrunk);
  std::vector<Vector3> corners;
  for (const auto& [a, b, c] : around.triangles) {
    const Vector3& p = around.vertices[a];
    const Vector3 normal = (around.vertices[b] - p).cross(around.vertices[c] - p);
    const double height = normal.dot(p);
    if (!(height > 0)) continue;
    // The corner where three planes meet. Where they are almost parallel it is inaccurate, and is
    // moved towards the centre until it is behind all planes.
    const Vector3 corner = normal / height;
    const double most = shrunk[planes.Farthest(corner)].dot(corner);
    corners.push_back(centre + corner / std::max(1.0, most));
    if (MustEnd(work, 1 + shrunk.size() / kPlanesPerStep)) return {};
  }
  return corners;
}

}  // namespace cwm::collision
