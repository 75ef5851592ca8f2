#include "perception/solids/free_space.h"

#include <algorithm>
#include <cmath>

#include "collision/geometry/aabb.h"
#include "perception/cloud/oriented_points.h"
#include "perception/cloud/tolerances.h"

namespace cwm::perception {
namespace {

// derived: 600 rays measure a share of 5 % (kMaxPassing) with a standard deviation of 0.9 %.
constexpr std::size_t kMinExaminedRays = 600;
// chosen: each step advances by at least 2 mm, so 24 steps cover 5 cm along a surface and far more
// elsewhere.
constexpr int kMaxSteps = 24;
// derived: a segment enters a solid if it is deeper than the unevenness of a surface. Steps are at
// least this long, so a straight wall of 3 mm or more is never stepped over.
constexpr double kEntered_m = kUnevenness_m;
// chosen: as a share of a solid's least extent, the depth that contradicts a thin solid. No point
// lies deeper than half of the extent, and the ends are known less well than that.
constexpr double kDeepShare = 0.35;

// True if the segment of length_m from p along the unit vector `way` reaches deeper than depth_m.
// It is traversed in steps (sphere tracing): the signed distance changes by at most the length of a
// step.
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

bool EntersSolid(const Solid& solid, const Vector3& begin, const Vector3& end) {
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

double CrossingRayShare(const Solid& solid, const FreeRays& free) {
  if (free.rays.empty()) return 0;
  const auto entering = std::count_if(free.rays.begin(), free.rays.end(), [&](const FreeRay& ray) {
    return EntersSolid(solid, ray.p.front(), ray.p.back());
  });
  return static_cast<double>(entering) / static_cast<double>(free.rays.size());
}

double DeepRayCount(const Solid& solid, const FreeRays& free) {
  const Pose X_SM = solid.X_MS.inverse(Eigen::Isometry);
  const auto deep = std::count_if(free.rays.begin(), free.rays.end(), [&](const FreeRay& ray) {
    const Vector3 way = ray.p.back() - ray.p.front();
    const double length_m = way.norm();
    return RunsDeep(solid, X_SM, ray.p.front(), way / length_m, length_m, kMaxDepth_m);
  });
  return static_cast<double>(deep) * free.weight;
}

bool IsPassedThrough(const Solid& solid, double points, const FreeRays& free) {
  // One sampled ray stands for many, and it may belong to a mixed pixel.
  return DeepRayCount(solid, free) > kMaxPassing * points + free.weight;
}

Contradiction FindContradiction(const Solid& solid, const ModelPoints& points) {
  const Pose X_SM = solid.X_MS.inverse();
  const Aabb bounds = TightBounds(solid.shape, solid.X_MS);
  const double deepest_m =
      kDeepShare * TightBounds(solid.shape, Pose::Identity()).sizes().minCoeff();
  const std::size_t stride = std::max<std::size_t>(1, points.size() / kMinExaminedRays);
  Contradiction found;
  for (std::size_t i = 0; i < points.size(); i += stride) {
    ++found.examined;
    const double depth_m = std::max(kMaxDepth_m, points.gate_m[i]);
    // The ray is followed from the point to the far side of the solid. In a solid thinner than
    // depth_m the noise of a surface point may put it that deep, so there the ray is followed only
    // from depth_m before the point.
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
