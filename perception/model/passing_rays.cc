#include "perception/model/passing_rays.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace cwm::perception {
namespace {

// Of those about the object, and of all: hardly any thing hangs so high above what it stands on that
// the second says more.
constexpr std::size_t kMostRaysAbout = 160, kMostRays = 480;
// Before what a ray met: its noise, and a mixed pixel's share of the way.
constexpr double kBefore_sigma = 3, kBefore_m = 0.005;

// About the points and their feet on the ground: a solid that stands or lies there fits in it.
struct Reach {
  Vector3 middle = Vector3::Zero();
  double radius_m = 0;
};

Reach ReachOf(const ModelPoints& points, const Ground& ground) {
  Eigen::AlignedBox3d bounds;
  for (const Vector3& p : points.p) {
    bounds.extend(p);
    bounds.extend(Vector3(p - ground.Height_m(p) * ground.up));
  }
  return {bounds.center(), 0.5 * bounds.diagonal().norm()};
}

}  // namespace

FreeRays RaysPast(const ModelPoints& points, const Ground& ground, const PassingRays& passing) {
  FreeRays out;
  if (points.size() == 0 || !ground.known) return out;
  const Reach reach = ReachOf(points, ground);
  std::size_t about = 0;
  for (std::size_t k = 0; k < passing.ends.size(); ++k) {
    const Vector3 ray = passing.ends[k].cast<double>() - points.origin_L - points.viewpoint;
    const double range_m = ray.norm();
    const double nearest_m = ray.dot(reach.middle - points.viewpoint) / range_m;
    const Vector3 nearest = points.viewpoint + nearest_m / range_m * ray;
    const double half_chord2 =
        reach.radius_m * reach.radius_m - (nearest - reach.middle).squaredNorm();
    if (!(half_chord2 > 0)) continue;
    const double sigma_m = passing.sigma_m[k];
    const double begin_m = nearest_m - std::sqrt(half_chord2);
    const double end_m =
        std::min(nearest_m + std::sqrt(half_chord2), range_m - kBefore_sigma * sigma_m - kBefore_m);
    if (!(end_m > begin_m)) continue;
    FreeRay free{.p = {}, .sigma_m = sigma_m};
    for (int j = 0; j < kFreePlaces; ++j) {
      const double at_m = begin_m + (j + 1.0) / kFreePlaces * (end_m - begin_m);
      free.p[static_cast<std::size_t>(j)] = points.viewpoint + at_m / range_m * ray;
    }
    out.rays.push_back(free);
    about += k < passing.about;
  }
  const std::size_t stride =
      std::max({std::size_t{1}, (about + kMostRaysAbout - 1) / kMostRaysAbout,
                (out.rays.size() + kMostRays - 1) / kMostRays});
  for (std::size_t k = 0; k * stride < out.rays.size(); ++k) out.rays[k] = out.rays[k * stride];
  out.rays.resize((out.rays.size() + stride - 1) / stride);
  out.weight = passing.weight * static_cast<double>(stride);
  return out;
}

double Clearance_m(const DistanceToShape& distance_m, const Pose& X_SR, const FreeRay& ray) {
  double least_m = std::numeric_limits<double>::infinity();
  for (const Vector3& p : ray.p) least_m = std::min(least_m, distance_m(X_SR * p));
  return least_m;
}

}  // namespace cwm::perception
