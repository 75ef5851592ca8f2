// The signed distance of a point to a solid's surface: the one formula per shape that fitting,
// inlier tests, kernels, completion and oracles share (lanes too: solid_distance-inl.h). Metres;
// negative inside. Exact (closed form) for every shape but meshes, where it is exact over the
// triangles, with the sign by winding (watertight) or always positive (open).
#pragma once

#include "collision/geometry/shape.h"

namespace cwm {

// The point of a surface nearest to a query point P, all in the shape's frame.
struct SurfacePoint {
  double signed_distance_m = 0;
  Vector3 nearest = Vector3::Zero();  // on the surface
  Vector3 normal =
      Vector3::UnitZ();  // unit, outward: the gradient of the signed distance where it exists; at a
                         // kink (centre of a sphere, axis of a cylinder) one of the valid ones
};

SurfacePoint NearestSurfacePoint(const Sphere& sphere, const Vector3& p);
SurfacePoint NearestSurfacePoint(const Box& box, const Vector3& p);
SurfacePoint NearestSurfacePoint(const Cylinder& cylinder, const Vector3& p);
SurfacePoint NearestSurfacePoint(const Cone& cone, const Vector3& p);
SurfacePoint NearestSurfacePoint(const Capsule& capsule, const Vector3& p);
SurfacePoint NearestSurfacePoint(const HalfSpace& half_space, const Vector3& p);
SurfacePoint NearestSurfacePoint(const Plate& plate, const Vector3& p);
SurfacePoint NearestSurfacePoint(const Convex& convex, const Vector3& p);
SurfacePoint NearestSurfacePoint(const Mesh& mesh, const Vector3& p);  // linear in the triangles
SurfacePoint NearestSurfacePoint(const Shape& shape, const Vector3& p);

inline double SignedDistance_m(const Shape& shape, const Vector3& p) {
  return NearestSurfacePoint(shape, p).signed_distance_m;
}

}  // namespace cwm
