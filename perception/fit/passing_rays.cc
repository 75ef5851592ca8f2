#include "perception/fit/passing_rays.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace cwm::perception {
namespace {

// chosen: bounds the work for rays about the object.
constexpr std::size_t kMaxRaysAbout = 320;
// chosen: bounds the work for all rays; few objects hang so high above their support that this
// thins more than the limit above.
constexpr std::size_t kMaxRaysInAll = kMaxRaysAbout * 3;
// chosen: six places span 4 cm, and fits move by less.
constexpr double kFreeSpacing_m = 0.008;
// chosen: length of the interval that holds the nearest place, so that it is known to 0.2 mm.
constexpr double kNearestWithin_m = 0.0004;
// derived: the ratio of the golden section.
constexpr double kGolden = std::numbers::phi - 1;
// chosen: the free part of a ray ends this far before the surface that it hit, besides the noise;
// mixed pixels lie in between.
constexpr double kBefore_m = 0.005;

// A sphere about the points and their projections on the ground: a solid that stands or lies there
// fits in it.
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

FreeRays FreeRaysPast(const ModelPoints& points, const Ground& ground, const PassingRays& passing) {
  FreeRays out;
  if (points.size() == 0 || !ground.known) return out;
  const Reach reach = ReachOf(points, ground);
  std::size_t around_count = 0;
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
    const double end_m = std::min(nearest_m + std::sqrt(half_chord2),
                                  range_m - kDistanceGate_sigma * sigma_m - kBefore_m);
    if (!(end_m > begin_m)) continue;
    FreeRay free{.p = {}, .sigma_m = sigma_m};
    for (int j = 0; j < kSamplesPerRay; ++j) {
      const double at_m = begin_m + (j + 1.0) / kSamplesPerRay * (end_m - begin_m);
      free.p[static_cast<std::size_t>(j)] = points.viewpoint + at_m / range_m * ray;
    }
    out.rays.push_back(free);
    around_count += k < passing.around_count;
  }
  const std::size_t stride =
      std::max({std::size_t{1}, (around_count + kMaxRaysAbout - 1) / kMaxRaysAbout,
                (out.rays.size() + kMaxRaysInAll - 1) / kMaxRaysInAll});
  for (std::size_t k = 0; k * stride < out.rays.size(); ++k) out.rays[k] = out.rays[k * stride];
  out.rays.resize((out.rays.size() + stride - 1) / stride);
  out.weight = passing.weight * static_cast<double>(stride);
  return out;
}

bool MayComeNear(const Vector3& middle, double radius_m, const FreeRay& ray) {
  const Vector3 way = ray.p.back() - ray.p.front(), from = middle - ray.p.front();
  const double at = std::clamp(way.dot(from) / way.squaredNorm(), 0.0, 1.0);
  return !((from - at * way).squaredNorm() > radius_m * radius_m);
}

NearestRayPoint FindNearestRayPoint(const DistanceToShape& distance_m, const Pose& X_SR,
                                    const FreeRay& ray) {
  NearestRayPoint best{.clearance_m = std::numeric_limits<double>::infinity()};
  std::size_t nearest = 0;
  for (std::size_t k = 0; k < ray.p.size(); ++k) {
    const double clearance_m = distance_m(X_SR * ray.p[k]);
    if (clearance_m < best.clearance_m) best = {clearance_m, ray.p[k]}, nearest = k;
  }
  Vector3 low = ray.p[nearest - (nearest > 0)];
  Vector3 high = ray.p[std::min(nearest + 1, ray.p.size() - 1)];
  // The distance changes by no more than the step, and it has one minimum along a line.
  if (best.clearance_m > (high - low).norm()) return best;
  double left_m = 0, right_m = 0;
  Vector3 left, right;
  const auto probe_left = [&] {
    left = high - kGolden * (high - low);
    left_m = distance_m(X_SR * left);
  };
  const auto probe_right = [&] {
    right = low + kGolden * (high - low);
    right_m = distance_m(X_SR * right);
  };
  probe_left();
  probe_right();
  while ((high - low).norm() > kNearestWithin_m) {
    if (left_m < right_m) {
      high = right, right = left, right_m = left_m;
      probe_left();
    } else {
      low = left, left = right, left_m = right_m;
      probe_right();
    }
  }
  if (left_m < best.clearance_m) best = {left_m, left};
  if (right_m < best.clearance_m) best = {right_m, right};
  return best;
}

FreeRay ResampledAround(const Vector3& p, const FreeRay& ray) {
  FreeRay placed{.p = {}, .sigma_m = ray.sigma_m};
  const Vector3 way = ray.p.back() - ray.p.front();
  const double length_m = way.norm();
  const double at_m = way.dot(p - ray.p.front()) / length_m;
  for (int k = 0; k < kSamplesPerRay; ++k) {
    const double aside_m = (k - 0.5 * (kSamplesPerRay - 1)) * kFreeSpacing_m;
    const double along_m = std::clamp(at_m + aside_m, 0.0, length_m);
    placed.p[static_cast<std::size_t>(k)] = ray.p.front() + along_m / length_m * way;
  }
  return placed;
}

}  // namespace cwm::perception
