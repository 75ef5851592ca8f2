// One triangle in space.
#pragma once

#include "collision/geometry/pose.h"

namespace cwm {

// The point of the triangle (a, b, c) nearest to `p`: the foot on its plane, or the nearest point
// of its edges. A triangle without area is its edges.
Vector3 NearestOnTriangle(const Vector3& a, const Vector3& b, const Vector3& c, const Vector3& p);

// Unit normal (b - a) x (c - a); UnitZ for a triangle without area.
Vector3 TriangleNormal(const Vector3& a, const Vector3& b, const Vector3& c);

}  // namespace cwm
