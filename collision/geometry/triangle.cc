#include "collision/geometry/triangle.h"

#include <algorithm>

#include "collision/geometry/segment.h"

namespace cwm {
namespace {

Vector3 NearestOnEdges(const Vector3& a, const Vector3& b, const Vector3& c, const Vector3& p) {
  Vector3 best = NearestOnSegment(a, b, p);
  for (const Vector3& q : {NearestOnSegment(b, c, p), NearestOnSegment(c, a, p)}) {
    if ((q - p).squaredNorm() < (best - p).squaredNorm()) best = q;
  }
  return best;
}

}  // namespace

Vector3 NearestOnTriangle(const Vector3& a, const Vector3& b, const Vector3& c, const Vector3& p) {
  const Vector3 ab = b - a, ac = c - a, ap = p - a;
  const Vector3 n = ab.cross(ac);
  const double nn = n.squaredNorm();
  if (!(nn > 0)) return NearestOnEdges(a, b, c, p);
  // Barycentric coordinates of the projection of p onto the plane.
  const double v = ap.cross(ac).dot(n) / nn;
  const double w = ab.cross(ap).dot(n) / nn;
  if (v >= 0 && w >= 0 && v + w <= 1) return p - ap.dot(n) / nn * n;
  return NearestOnEdges(a, b, c, p);
}

Vector3 TriangleNormal(const Vector3& a, const Vector3& b, const Vector3& c) {
  const Vector3 n = (b - a).cross(c - a);
  const double norm = n.stableNorm();
  return norm > 0 ? Vector3(n / norm) : Vector3::UnitZ();
}

std::optional<Vector3> ReliableNormal(const Vector3& a, const Vector3& b, const Vector3& c) {
  constexpr double kMinHeightShare = 1e-9;
  const double longest_squared =
      std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()});
  const Vector3 n = (b - a).cross(c - a);
  const double norm = n.stableNorm();
  if (!(norm > kMinHeightShare * longest_squared)) return std::nullopt;
  return Vector3(n / norm);
}

}  // namespace cwm
