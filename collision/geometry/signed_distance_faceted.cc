// Signed distances to solids made of triangles.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "collision/geometry/signed_distance.h"
#include "collision/geometry/triangle.h"
#include "collision/geometry/winding.h"

namespace cwm {
namespace {

struct NearestTriangle {
  double distance = std::numeric_limits<double>::infinity();
  Vector3 nearest = Vector3::Zero();
  Vector3 face_normal = Vector3::UnitZ();
};

std::array<Vector3, 3> Corners(const TriangleMesh& mesh, const TriangleMesh::Triangle& t) {
  return {mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]};
}

// The direction away from the surface; on the surface itself, the normal of the face.
Vector3 NormalAt(const NearestTriangle& at, const Vector3& p, double sign) {
  const Vector3 offset = p - at.nearest;
  const double size = std::max(p.cwiseAbs().maxCoeff(), at.nearest.cwiseAbs().maxCoeff());
  // At smaller distances, the offset consists of the rounding of poses.
  if (at.distance <= 1e-11 * size) return at.face_normal;
  return sign * offset / at.distance;
}

}  // namespace

SurfacePoint NearestSurfacePoint(const Convex& convex, const Vector3& p) {
  const TriangleMesh& hull = *convex.hull;
  double size = p.cwiseAbs().maxCoeff();
  for (const Vector3& v : hull.vertices) size = std::max(size, v.cwiseAbs().maxCoeff());
  // Coplanar triangles differ by rounding: a point this near to a plane may lie on either side.
  const double tolerance = 1e-14 * size;
  NearestTriangle outside;
  double highest_plane = -std::numeric_limits<double>::infinity();
  Vector3 highest_normal = Vector3::UnitZ();
  for (const TriangleMesh::Triangle& t : hull.triangles) {
    const auto [a, b, c] = Corners(hull, t);
    const std::optional<Vector3> sure_normal = ReliableNormal(a, b, c);
    if (!sure_normal) continue;  // its neighbours are just as near
    const Vector3& normal = *sure_normal;
    const double plane_distance = normal.dot(p - a);
    if (plane_distance > highest_plane) {
      highest_plane = plane_distance;
      highest_normal = normal;
    }
    if (plane_distance < -tolerance) continue;  // a face seen from behind is never the nearest
    const Vector3 nearest = NearestOnTriangle(a, b, c, p);
    const double distance = (p - nearest).norm();
    if (distance < outside.distance) outside = {distance, nearest, normal};
  }
  if (highest_plane <= tolerance) {
    return {highest_plane, p - highest_plane * highest_normal, highest_normal};
  }
  return {outside.distance, outside.nearest, NormalAt(outside, p, 1.0)};
}

SurfacePoint NearestSurfacePoint(const Mesh& mesh, const Vector3& p) {
  NearestTriangle best;
  for (const TriangleMesh::Triangle& t : mesh.mesh->triangles) {
    const auto [a, b, c] = Corners(*mesh.mesh, t);
    const Vector3 nearest = NearestOnTriangle(a, b, c, p);
    const double distance = (p - nearest).norm();
    if (distance < best.distance) best = {distance, nearest, TriangleNormal(a, b, c)};
  }
  // A mesh that is wound inward is as solid as its mirror image.
  const bool inside = mesh.watertight && std::abs(WindingNumber(*mesh.mesh, p)) > 0.5;
  const double sign = inside ? -1 : 1;
  return {sign * best.distance, best.nearest, NormalAt(best, p, sign)};
}

}  // namespace cwm
