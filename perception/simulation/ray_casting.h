// Casts a ray at the surface of a shape.
#pragma once

#include <optional>

#include "collision/geometry/shape.h"

namespace cwm::perception {

// The points origin + t * direction with t > 0. The direction has any positive length, which is the
// unit of t.
struct Ray {
  Vector3 origin = Vector3::Zero();
  Vector3 direction = Vector3::UnitZ();
};

struct RayHit {
  double t = 0;
  Vector3 normal = Vector3::UnitZ();  // unit, turned towards the ray's origin
};

// Returns the hit of smallest t > 0; ray and hit are in the shape's frame. A ray that starts inside
// a solid hits it from within. A ray that only touches (tangentially, or within a face) may hit or
// miss. Closed form for every shape; linear in the edges of a plate and the triangles of a mesh.
std::optional<RayHit> CastRay(const Shape& shape, const Ray& ray);

// The hit on one triangle, from either side.
std::optional<RayHit> CastRay(const Vector3& a, const Vector3& b, const Vector3& c, const Ray& ray);

}  // namespace cwm::perception
