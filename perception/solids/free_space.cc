#include "perception/solids/free_space.h"

#include <algorithm>
#include <cmath>

#include "collision/geometry/aabb.h"
#include "perception/cloud/oriented_points.h"
#include "perception/cloud/tolerances.h"

namespace cwm::perception {
namespace {

// derived: of 600 rays a share of 5 % (kMaxPassing) is known to 0.9 %.
constexpr std::size_t kMinLookedAt = 600;
// chosen: each step advances by at least 2 mm, so that these cross 5 cm along a surface and far
// more elsewhere.
constexpr int kMaxSteps = 24;
// derived: less than the unevenness of a surface is no entrance; in steps of as much, where the
// surface is straight, a wall of 3 mm is not stepped over.
constexpr double kEntered_m = kUnevenness_m;
// chosen: of a solid's least extent. Nothing lies deeper than half of it, and its ends are known to
// less.
constexpr double kDeepShare = 0.35;

// The deepest place of the segment in the solid is found by steps of what is known to be free of
// deeper places: the signed distance changes by at most the length of a step. `way` is a unit
// vector.
bool RunsDeep(const Solid& solid, const Pose& X_SM, const Vector3& p, const Vector3& way,
              double length_m, double depth_m) {
  double t = 0;
  for (int step = 0; step < kMaxSteps && t < length_m; ++step) {
    const double signed_m = SignedDistance_m(solid, X_SM * (p + t * way));
    if (signed_m < -depth_m) return true;
    t += std::max(signed_m + depth_m, 2 * kEntered_m);
  }
  return false;
}

}  // namespace

bool Enters(const Solid& solid, const Vector3& begin, const Vector3& end) {
  const Pose X_SM = solid.X_MS.inverse(Eigen::Isometry);
  const Vector3 from = X_SM * begin, way = X_SM * end - from;
  const double length_m = way.norm();
  for (double t = 0; t < length_m;) {
    const double distance_m = SignedDistance_m(solid, from + t / length_m * way);
    if (distance_m < -kEntered_m) return true;
    t += std::max(std::abs(distance_m), kEntered_m);
  }
  return false;
}

double PassedShare(const Solid& solid, const FreeRays& free) {
  if (free.rays.empty()) return 0;
  const auto entering = std::count_if(free.rays.begin(), free.rays.end(), [&](const FreeRay& ray) {
    return Enters(solid, ray.p.front(), ray.p.back());
  });
  return static_cast<double>(entering) / static_cast<double>(free.rays.size());
}

double PassedDeep(const Solid& solid, const FreeRays& free) {
  const Pose X_SM = solid.X_MS.inverse(Eigen::Isometry);
  const auto deep = std::count_if(free.rays.begin(), free.rays.end(), [&](const FreeRay& ray) {
    const Vector3 way = ray.p.back() - ray.p.front();
    const double length_m = way.norm();
    return RunsDeep(solid, X_SM, ray.p.front(), way / length_m, length_m, kMaxDepth_m);
  });
  return static_cast<double>(deep) * free.weight;
}

bool IsPassedThrough(const Solid& solid, double points, const FreeRays& free) {
  // One sampled ray stands for many, and may be a mixed pixel's.
  return PassedDeep(solid, free) > kMaxPassing * points + free.weight;
}

Contradiction FindContradiction(const Solid& solid, const ModelPoints& points) {
  const Pose X_SM = solid.X_MS.inverse();
  const Aabb bounds = TightBounds(solid.shape, solid.X_MS);
  const double deepest_m =
      kDeepShare * TightBounds(solid.shape, Pose::Identity()).sizes().minCoeff();
  const std::size_t stride = std::max<std::size_t>(1, points.size() / kMinLookedAt);
  Contradiction found;
  for (std::size_t i = 0; i < points.size(); i += stride) {
    ++found.looked;
    const double depth_m = std::max(kMaxDepth_m, points.gate_m[i]);
    // From the point, no farther than the other side of the solid. In what is thinner than that
    // depth, a point of its own surface is as deep by its noise: there from where it has left that
    // behind.
    const double reach_m = (points.p[i] - bounds.center()).norm() + 0.5 * bounds.diagonal().norm();
    const double begin_m = deepest_m < depth_m ? depth_m : 0;
    const Vector3 to_sensor = points.viewpoint - points.p[i];
    const double range_m = to_sensor.norm();
    const Vector3 way = to_sensor / range_m;
    found.rays += RunsDeep(solid, X_SM, points.p[i] + begin_m * way, way,
                           std::min(range_m, reach_m) - begin_m, std::min(depth_m, deepest_m));
  }
  return found;
}

}  // namespace cwm::perception
