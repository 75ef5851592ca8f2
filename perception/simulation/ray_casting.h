// Where a ray first meets the surface of a shape: what the virtual scanner sees.
#pragma once

#include <optional>

#include "collision/geometry/shape.h"

namespace cwm::perception {

// The points origin + t * direction with t > 0. The direction may have any positive length; t
// counts in units of it.
struct Ray {
  Vector3 origin = Vector3::Zero();
  Vector3 direction = Vector3::UnitZ();
};

struct RayHit {
  double t = 0;
  Vector3 normal = Vector3::UnitZ();  // unit, turned towards the ray's origin
};

// The hit of smallest t > 0, ray and hit in the shape's frame. A ray that starts inside a solid
// hits it from within. A ray that only touches (tangent, or running in a face) may count either
// way. Closed form for every shape; linear in the edges of a plate and in the triangles of a mesh.
std::optional<RayHit> CastRay(const Shape& shape, const Ray& ray);

// One triangle, seen from either side.
std::optional<RayHit> CastRay(const Vector3& a, const Vector3& b, const Vector3& c, const Ray& ray);

}  // namespace cwm::perception
