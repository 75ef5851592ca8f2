// Rays that passed an object and hit what is beside or behind it: the space that they crossed is
// free. The points on a round top constrain the wall below it weakly; the rays beside it bound the
// width of the foot and rule out the corners of a box.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "collision/geometry/distance_to_shape.h"
#include "collision/geometry/pose.h"
#include "perception/fit/ground.h"
#include "perception/search/model_points.h"

namespace cwm::perception {

// An even sample of measured rays, in the level frame, from the viewpoint of the object's points.
// Each ray stands for `weight` measured ones.
struct PassingRays {
  std::vector<Eigen::Vector3f> ends;  // metres; rays about the object, then rays below it
  std::vector<float> sigma_m;         // of the range
  std::size_t around_count = 0;       // the number of rays about the object
  double weight = 1;
};

// A ray's free places, at even distances: from where it comes near the object to where it leaves
// it, or to just before the surface that it hit.
// chosen: 8 mm apart (ResampledAround) they span 4 cm, and fits move by less.
inline constexpr int kSamplesPerRay = 6;
struct FreeRay {
  std::array<Vector3, kSamplesPerRay> p;  // in the frame of the model points
  double sigma_m = 0;
};
struct FreeRays {
  std::vector<FreeRay> rays;
  double weight = 1;  // measured rays that each stands for
};

// Returns the rays that come near the space between the points and the ground below them. Rays
// about the object and rays below it are thinned alike.
FreeRays FreeRaysPast(const ModelPoints& points, const Ground& ground, const PassingRays& passing);

// True if the ray comes within radius_m of `middle`. With a solid's bounding sphere this rejects
// most rays.
bool MayComeNear(const Vector3& middle, double radius_m, const FreeRay& ray);

// The place of a ray that is deepest in a convex solid or, if the ray stays outside, nearest to it.
struct NearestRayPoint {
  double clearance_m = 0;       // signed distance to the surface, negative inside
  Vector3 p = Vector3::Zero();  // in the ray's frame
};
// Returns the nearest place, known to 0.2 mm along the ray if the ray comes so near that it may
// enter the solid. X_SR transforms from the frame in which the ray is given.
NearestRayPoint FindNearestRayPoint(const DistanceToShape& distance_m, const Pose& X_SR,
                                    const FreeRay& ray);

// Returns the ray with its places 8 mm apart about the point p, clamped to its free part. Fits move
// by less than that span.
FreeRay ResampledAround(const Vector3& p, const FreeRay& ray);

}  // namespace cwm::perception
