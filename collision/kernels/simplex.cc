#include "collision/kernels/simplex.h"

#include <algorithm>
#include <cmath>

namespace cwm::collision {
namespace {

// derived: rounding error of a determinant of three vectors, as a share of the product of their
// lengths: a dozen roundings of double precision.
constexpr double kRounding = 4e-15;

using SimplexCorners = std::array<Vector3, 4>;

SimplexFeature AtCorner(const SimplexCorners& corners, int i) {
  SimplexFeature feature;
  feature.index[0] = i;
  feature.nearest = corners[i];
  feature.distance_squared = corners[i].squaredNorm();
  return feature;
}

SimplexFeature OnEdge(const SimplexCorners& corners, int i, int j) {
  const Vector3 &a = corners[i], &b = corners[j];
  const Vector3 ab = b - a;
  const double length_squared = ab.squaredNorm();
  const double along = -a.dot(ab);
  if (!(along > 0)) return AtCorner(corners, i);
  if (!(along < length_squared)) return AtCorner(corners, j);
  const double t = along / length_squared;
  SimplexFeature feature;
  feature.count = 2;
  feature.index = {i, j, 0, 0};
  feature.weight = {1 - t, t, 0, 0};
  feature.nearest = a + t * ab;
  feature.distance_squared = feature.nearest.squaredNorm();
  return feature;
}

const SimplexFeature& Nearer(const SimplexFeature& a, const SimplexFeature& b) {
  return b.distance_squared < a.distance_squared ? b : a;
}

SimplexFeature OnTriangle(const SimplexCorners& corners, int i, int j, int k) {
  const Vector3 &a = corners[i], &b = corners[j], &c = corners[k];
  const Vector3 n = (b - a).cross(c - a);
  const double nn = n.squaredNorm();
  // Barycentric coordinates of the origin's projection, times nn.
  const double u = b.cross(c).dot(n), v = c.cross(a).dot(n), w = a.cross(b).dot(n);
  if (nn > 0 && u >= 0 && v >= 0 && w >= 0) {
    SimplexFeature feature;
    feature.count = 3;
    feature.index = {i, j, k, 0};
    const double sum = u + v + w;
    if (sum > 0) {
      feature.weight = {u / sum, v / sum, w / sum, 0};
      feature.nearest = n * (a.dot(n) / nn);
      feature.distance_squared = feature.nearest.squaredNorm();
      return feature;
    }
  }
  const SimplexFeature ab = OnEdge(corners, i, j), bc = OnEdge(corners, j, k),
                       ca = OnEdge(corners, k, i);
  return Nearer(Nearer(ab, bc), ca);
}

SimplexFeature OnTetrahedron(const SimplexCorners& corners) {
  static constexpr int kFaces[4][4] = {{0, 1, 2, 3}, {0, 2, 3, 1}, {0, 3, 1, 2}, {1, 3, 2, 0}};
  SimplexFeature best;
  bool outside = false;
  for (const auto& [i, j, k, opposite] : kFaces) {
    const Vector3 u = corners[j] - corners[i], v = corners[k] - corners[i];
    const Vector3 w = corners[opposite] - corners[i];
    const Vector3 n = u.cross(v);
    const double origin_side = -n.dot(corners[i]), inner_side = n.dot(w);
    // A side that rounding determines proves nothing, so the face stays a candidate. In a flat
    // tetrahedron all four faces do.
    const double area = u.norm() * v.norm();
    const bool is_sure = std::abs(origin_side) > kRounding * area * corners[i].norm() &&
                         std::abs(inner_side) > kRounding * area * w.norm();
    if (is_sure && (origin_side > 0) == (inner_side > 0)) continue;
    const SimplexFeature feature = OnTriangle(corners, i, j, k);
    if (!outside || feature.distance_squared < best.distance_squared) best = feature;
    outside = true;
  }
  if (outside) return best;
  best.count = 4;
  best.nearest.setZero();
  best.distance_squared = 0;
  best.weight = {0.25, 0.25, 0.25, 0.25};
  return best;
}

}  // namespace

SimplexFeature NearestToOrigin(const SimplexCorners& corners, int count) {
  switch (count) {
    case 1:
      return AtCorner(corners, 0);
    case 2:
      return OnEdge(corners, 0, 1);
    case 3:
      return OnTriangle(corners, 0, 1, 2);
    default:
      return OnTetrahedron(corners);
  }
}

}  // namespace cwm::collision
