// Ray casts against the shapes that have a formula, in the shape's frame.
#pragma once

#include <optional>

#include "collision/kernels/exact.h"

namespace cwm::collision {

// The first point of the surface at a distance in [0, ray.max_distance_m], from outside or inside.
// Empty for meshes, which are hit through their tree (TriangleTree::CastRay).
std::optional<RayHit> CastRay(const Shape& shape, const Ray& ray);

}  // namespace cwm::collision
