// One point against one solid of which the distance has no short formula: profiles, hulls, meshes.
#pragma once

#include <limits>
#include <optional>

#include "collision/geometry/hybrid_model.h"
#include "collision/kernels/plane_profile.h"
#include "collision/kernels/triangle_tree.h"

namespace cwm::collision {

struct PointSample {
  double distance_m = 0;                // as SignedDistance_m
  Vector3 gradient = Vector3::UnitZ();  // unit: how the distance grows; at a kink one of the ways
  bool kink = false;                    // see kink.h
  // In a mesh that overlaps itself: the place to which the distance is lies in the solid too, so
  // that the point is deeper.
  bool buried = false;
};

// Of cones, vessels and plates by their profile: p in the shape's frame.
PointSample SampleRevolved(const PlaneProfile& profile, const Vector3& p);
PointSample SamplePlate(const PlaneProfile& outline, double thickness_m, const Vector3& p);
PointSample SampleConvex(const Convex& convex, const Vector3& p);

// Of a mesh by its tree; an open one has no inside, and a kink all over its surface. `distance_m` is
// what MeshDistance_m told of the point.
PointSample SampleMesh(const TriangleTree& tree, bool watertight, const Vector3& p,
                       double distance_m, WorkCounter* work = nullptr);
// Some distance beyond `max_distance_m` for what lies farther outside than that.
double MeshDistance_m(const TriangleTree& tree, bool watertight, const Vector3& p,
                      double max_distance_m, WorkCounter* work = nullptr);

// The profile of a vessel, from the axis below the foot to the axis on the floor.
PlaneProfile VesselProfile(const VesselShell& shell);

}  // namespace cwm::collision
