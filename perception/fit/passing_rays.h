// Rays that passed an object by, to what lies beside and behind it: the space that they crossed is
// free. What is measured of a round top says little about the wall below it; what is seen beside it
// says how wide the foot may be, and that no box has its corners there.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "collision/geometry/distance_to_shape.h"
#include "collision/geometry/pose.h"
#include "perception/fit/ground.h"
#include "perception/search/model_points.h"

namespace cwm::perception {

// As measured, in the level frame, from the viewpoint of the object's points. Even samples, each
// for `weight` measured rays.
struct PassingRays {
  std::vector<Eigen::Vector3f> ends;  // metres; of rays about the object, then of those below it
  std::vector<float> sigma_m;         // of the range
  std::size_t about = 0;              // how many of them are about the object
  double weight = 1;
};

// Where one of them is known to be free: places at even distances, from where it comes near the
// object to where it leaves it or to just before what it met.
// chosen: 8 mm apart (PlacedAround) they span 4 cm, and fits move by less.
inline constexpr int kFreePlaces = 6;
struct FreeRay {
  std::array<Vector3, kFreePlaces> p;  // in the frame of the model points
  double sigma_m = 0;
};
struct FreeRays {
  std::vector<FreeRay> rays;
  double weight = 1;  // measured rays that each stands for
};

// Those that come near what the points and the ground below them leave room for: as many of those
// below as there are per view of those about it.
FreeRays RaysPast(const ModelPoints& points, const Ground& ground, const PassingRays& passing);

// Whether any of the ray is within that of a place: tells most rays from a solid's bounding sphere.
bool MayComeNear(const Vector3& middle, double radius_m, const FreeRay& ray);

// Where a ray is deepest in a convex solid or, outside, nearest to it.
struct NearestPlace {
  double clearance_m = 0;       // signed distance to the surface, negative inside
  Vector3 p = Vector3::Zero();  // in the ray's frame
};
// To 0.2 mm of the way where the ray comes so near that it may be inside. X_SR is of the frame in
// which the ray is given.
NearestPlace NearestTo(const DistanceToShape& distance_m, const Pose& X_SR, const FreeRay& ray);

// The ray with its places 8 mm apart about one of its points, no farther than it is free: fits move
// by less than that.
FreeRay PlacedAround(const Vector3& p, const FreeRay& ray);

}  // namespace cwm::perception
