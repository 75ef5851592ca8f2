// Support mappings: the point of a convex shape that lies farthest in a direction. GJK, the search
// for the minimum translation and half-spaces need nothing else of a shape.
#pragma once

#include <cmath>
#include <span>

#include "collision/geometry/shape.h"

namespace cwm {

// A point of the shape, in its frame, that maximises the dot product with `d`. `d` need not be a
// unit vector and may be zero (any point of the shape then). Deterministic if several points are
// equally far. Inline because the inner loops of the narrow phase call it.
inline Vector3 SupportPoint(const Box& box, const Vector3& d) {
  return {std::copysign(0.5 * box.size_m.x(), d.x()), std::copysign(0.5 * box.size_m.y(), d.y()),
          std::copysign(0.5 * box.size_m.z(), d.z())};
}

// Support point of the disc of the given radius about the axis in the plane at height z.
inline Vector3 SupportOfDisc(double radius_m, double z_m, const Vector3& d) {
  const double norm_squared = d.x() * d.x() + d.y() * d.y();
  if (!(norm_squared > 0)) return {0, 0, z_m};
  const double scale = radius_m / std::sqrt(norm_squared);
  return {scale * d.x(), scale * d.y(), z_m};
}

inline Vector3 SupportPoint(const Cylinder& cylinder, const Vector3& d) {
  return SupportOfDisc(cylinder.radius_m, std::copysign(0.5 * cylinder.length_m, d.z()), d);
}

inline Vector3 SupportPoint(const Cone& cone, const Vector3& d) {
  const double half = 0.5 * cone.length_m;
  const double radial = std::sqrt(d.x() * d.x() + d.y() * d.y());
  const bool top = (cone.radius_top_m - cone.radius_bottom_m) * radial + cone.length_m * d.z() > 0;
  return SupportOfDisc(top ? cone.radius_top_m : cone.radius_bottom_m, top ? half : -half, d);
}

// Support point of the hull of at least one vertex.
inline Vector3 SupportPoint(std::span<const Vector3> vertices, const Vector3& d) {
  const Vector3* best = vertices.data();
  double best_dot = best->dot(d);
  for (const Vector3& vertex : vertices.subspan(1)) {
    const double dot = vertex.dot(d);
    if (dot <= best_dot) continue;
    best_dot = dot;
    best = &vertex;
  }
  return *best;
}

}  // namespace cwm
