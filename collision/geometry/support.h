// Support mappings: the point of a convex shape that lies farthest in a direction. Everything that
// GJK, EPA, bounds and overlap along an axis need to know of a shape.
#pragma once

#include <array>
#include <cmath>
#include <vector>

#include "collision/geometry/shape.h"

namespace cwm {

// A point of the shape, in its frame, that maximises the dot product with `d`. `d` need not be
// unit and may be zero (any point of the shape then). Deterministic among equals.
Vector3 SupportPoint(const Sphere& sphere, const Vector3& d);
Vector3 SupportPoint(const Box& box, const Vector3& d);
Vector3 SupportPoint(const Cylinder& cylinder, const Vector3& d);
Vector3 SupportPoint(const Cone& cone, const Vector3& d);
Vector3 SupportPoint(const Capsule& capsule, const Vector3& d);
Vector3 SupportPoint(const std::vector<Vector3>& vertices, const Vector3& d);  // not empty

}  // namespace cwm
