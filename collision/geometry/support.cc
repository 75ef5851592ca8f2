#include "collision/geometry/support.h"

namespace cwm {
namespace {

// The point of a disc in the plane z = `z`.
Vector3 SupportOfDisc(double radius, double z, const Vector3& d) {
  const double norm = std::hypot(d.x(), d.y());
  if (!(norm > 0)) return {0, 0, z};
  return {radius * (d.x() / norm), radius * (d.y() / norm), z};
}

}  // namespace

Vector3 SupportPoint(const Sphere& sphere, const Vector3& d) {
  const double norm = d.stableNorm();
  return norm > 0 ? Vector3(d * (sphere.radius_m / norm)) : Vector3(0, 0, sphere.radius_m);
}

Vector3 SupportPoint(const Box& box, const Vector3& d) {
  return {std::copysign(0.5 * box.size_m.x(), d.x()), std::copysign(0.5 * box.size_m.y(), d.y()),
          std::copysign(0.5 * box.size_m.z(), d.z())};
}

Vector3 SupportPoint(const Cylinder& cylinder, const Vector3& d) {
  return SupportOfDisc(cylinder.radius_m, std::copysign(0.5 * cylinder.length_m, d.z()), d);
}

Vector3 SupportPoint(const Cone& cone, const Vector3& d) {
  const double half = 0.5 * cone.length_m;
  const double radial = std::hypot(d.x(), d.y());
  const bool top =
      cone.radius_top_m * radial + half * d.z() > cone.radius_bottom_m * radial - half * d.z();
  return top ? SupportOfDisc(cone.radius_top_m, half, d)
             : SupportOfDisc(cone.radius_bottom_m, -half, d);
}

Vector3 SupportPoint(const Capsule& capsule, const Vector3& d) {
  const Vector3 centre(0, 0, std::copysign(0.5 * capsule.length_m, d.z()));
  return centre + SupportPoint(Sphere{capsule.radius_m}, d);
}

Vector3 SupportPoint(const std::vector<Vector3>& vertices, const Vector3& d) {
  std::size_t best = 0;
  double best_dot = vertices[0].dot(d);
  for (std::size_t i = 1; i < vertices.size(); ++i) {
    const double dot = vertices[i].dot(d);
    if (dot > best_dot) {
      best_dot = dot;
      best = i;
    }
  }
  return vertices[best];
}

}  // namespace cwm
