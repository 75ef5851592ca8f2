// The winding number of a closed mesh around a point.
#pragma once

#include "collision/geometry/triangle_mesh.h"

namespace cwm {

// The signed solid angle of the triangle (a, b, c) seen from the origin, in [-2 pi, 2 pi] (Van
// Oosterom and Strackee 1983). 0 when the origin lies in its plane outside of it.
double SolidAngle_sr(const Vector3& a, const Vector3& b, const Vector3& c);

// 1 inside and 0 outside of a simple outward-wound watertight mesh, up to rounding; any value on
// the surface. The cost is linear in the triangles.
double WindingNumber(const TriangleMesh& mesh, const Vector3& p);

}  // namespace cwm
