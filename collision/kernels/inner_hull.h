// A convex solid within the solid of a mesh, close to its convex hull.
#pragma once

#include <vector>

#include "collision/kernels/triangle_tree.h"

namespace cwm::collision {

// The planes of a hull around a point in it, as points n / h of the polar set: a point p lies
// inside the plane, shrunk by a scale, if (p - centre).dot(n / h) is below that scale. The height h
// is that of the farthest vertex along n, so no vertex is outside a plane, even if n is the
// inaccurate normal of a sliver.
std::vector<Vector3> PolarOf(const TriangleMesh& hull, const Vector3& centre);

// A scale of each plane, at most 1, so that every triangle has all three corners beyond one of the
// shrunk planes. The solid behind all of them then has no triangle in its interior. Each triangle
// shrinks only the plane that is nearest to it. Stops at the first scale below `min_scale`, or if
// `work` ends it. Precondition: there is a plane.
std::vector<double> PlaneScales(const std::vector<Vector3>& polar, const Vector3& centre,
                                const TriangleTree& tree, double min_scale,
                                WorkCounter* work = nullptr);

// Corners of the solid behind the shrunk planes. The hull of these corners lies in it up to
// roundings; it is the solid itself, unless planes are almost parallel. Empty if `work` ended the
// search. Scales are positive.
std::vector<Vector3> CornersBehind(const std::vector<Vector3>& polar,
                                   const std::vector<double>& scales, const Vector3& centre,
                                   WorkCounter* work = nullptr);

}  // namespace cwm::collision
