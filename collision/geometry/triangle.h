// One triangle in space.
#pragma once

#include <optional>

#include "collision/geometry/pose.h"

namespace cwm {

// The point of the triangle (a, b, c) nearest to `p`: the projection onto its plane, or the nearest
// point of its edges. Only the edges count in a triangle without area.
Vector3 NearestOnTriangle(const Vector3& a, const Vector3& b, const Vector3& c, const Vector3& p);

// Unit normal (b - a) x (c - a); UnitZ for a triangle without area.
Vector3 TriangleNormal(const Vector3& a, const Vector3& b, const Vector3& c);

// The same; empty for a triangle whose least height is below 1e-9 of its longest edge, because
// rounding of the corners determines its plane. Such triangles keep a hull watertight where a
// corner lies on an edge; they bound nothing that their neighbours do not bound.
std::optional<Vector3> ReliableNormal(const Vector3& a, const Vector3& b, const Vector3& c);

}  // namespace cwm
