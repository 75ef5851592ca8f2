// The distance of one point to one solid without a short formula: profiles, hulls, meshes.
#pragma once

#include <limits>
#include <optional>

#include "collision/geometry/hybrid_model.h"
#include "collision/kernels/plane_profile.h"
#include "collision/kernels/triangle_tree.h"

namespace cwm::collision {

struct PointSample {
  double distance_m = 0;                // the same as SignedDistance_m
  Vector3 gradient = Vector3::UnitZ();  // unit gradient of the distance; at a kink one of several
  bool kink = false;                    // see kink.h
  // True in a mesh that overlaps itself if the nearest surface point lies inside the solid too, so
  // that the point is deeper than distance_m says.
  bool nearest_is_interior = false;
};

// Samples cones and vessels by their profile, plates by their outline, and hulls; p in the shape's
// frame.
PointSample SampleRevolved(const PlaneProfile& profile, const Vector3& p);
PointSample SamplePlate(const PlaneProfile& outline, double thickness_m, const Vector3& p);
PointSample SampleConvex(const Convex& convex, const Vector3& p);

// Samples a mesh by its tree. An open mesh has no inside, and a kink on all of its surface.
// `distance_m` is the result of MeshDistance_m for the point.
PointSample SampleMesh(const TriangleTree& tree, bool watertight, const Vector3& p,
                       double distance_m, WorkCounter* work = nullptr);
// The signed distance of p; infinity if p lies farther outside than `max_distance_m`.
double MeshDistance_m(const TriangleTree& tree, bool watertight, const Vector3& p,
                      double max_distance_m, WorkCounter* work = nullptr);

// The profile of a vessel, from the axis below the foot to the axis on the floor.
PlaneProfile VesselProfile(const VesselShell& shell);

}  // namespace cwm::collision
