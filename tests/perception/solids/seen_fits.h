// Exact points on surfaces with the fits through them, put together by hand for the tests of
// solids: no noise, no search.
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "perception/cloud/tolerances.h"
#include "perception/fit/shape_fit.h"

namespace cwm::perception {

// Ends are known to half a bin of the histogram that ExtentAlong uses.
inline constexpr double kSeenEnd_m = 0.0025;
// The accuracy of values that exact points determine.
inline constexpr double kSeenExact_m = 1e-9;

inline const Ground kFloorAtZero{.known = true};

// A ray that is known to be free from one place to the other.
inline FreeRay RayBetween(const Vector3& from, const Vector3& to) {
  FreeRay ray{.p = {}, .sigma_m = 0.0015};
  for (int k = 0; k < kSamplesPerRay; ++k) {
    ray.p[static_cast<std::size_t>(k)] = from + k / (kSamplesPerRay - 1.0) * (to - from);
  }
  return ray;
}

// Points and fits in the frame M; points are 4 mm apart, with a sigma of 1.5 mm.
class SeenFits {
 public:
  static constexpr double kApart_m = 0.004, kSigma_m = 0.0015;
  // The standard deviation of each parameter of a fit.
  static constexpr double kFitSigma = 1e-4;

  explicit SeenFits(const Vector3& viewpoint) {
    points_.viewpoint = viewpoint;
    points_.spacing_m = kApart_m;
    points_.max_gate_m = kDistanceGate_sigma * kSigma_m;
  }

  std::uint32_t AddPoint(const Vector3& p, const Vector3& n) {
    const auto at = static_cast<std::uint32_t>(points_.size());
    points_.p.push_back(p);
    points_.n.push_back(n);
    points_.sigma_m.push_back(kSigma_m);
    points_.gate_m.push_back(kDistanceGate_sigma * kSigma_m);
    points_.min_cos.push_back(std::cos(kSameNormal_rad));
    points_.key.push_back(0);
    points_.index.push_back(at);
    return at;
  }

  // Adds a grid from edge to edge of a rectangle, whose normal is the cross product of its sides.
  ShapeFit AddFace(const Vector3& corner, const Vector3& along, const Vector3& across) {
    const PlaneModel plane{.point = corner + 0.5 * (along + across),
                           .normal = along.cross(across).normalized()};
    const auto columns = std::lround(along.norm() / kApart_m);
    const auto rows = std::lround(across.norm() / kApart_m);
    std::vector<std::uint32_t> on;
    for (long i = 0; i <= columns; ++i) {
      const Vector3 foot = corner + static_cast<double>(i) / static_cast<double>(columns) * along;
      for (long j = 0; j <= rows; ++j) {
        const Vector3 up = static_cast<double>(j) / static_cast<double>(rows) * across;
        on.push_back(AddPoint(foot + up, plane.normal));
      }
    }
    return Fit(plane, std::move(on));
  }

  // Adds a level disc, seen from above, which `count` points fill evenly (Vogel 1979).
  ShapeFit AddDisc(const Vector3& center, double radius_m, int count) {
    constexpr double kTurn_rad = 2 * std::numbers::pi * (std::numbers::phi - 1);
    std::vector<std::uint32_t> on;
    for (int k = 0; k < count; ++k) {
      const double away_m = radius_m * std::sqrt((k + 0.5) / count);
      const Vector3 way(std::cos(k * kTurn_rad), std::sin(k * kTurn_rad), 0);
      on.push_back(AddPoint(center + away_m * way, Vector3::UnitZ()));
    }
    return Fit(PlaneModel{.point = center, .normal = Vector3::UnitZ()}, std::move(on));
  }
  ShapeFit AddDisc(const Vector3& center, double radius_m) {
    const double area_m2 = std::numbers::pi * radius_m * radius_m;
    return AddDisc(center, radius_m, static_cast<int>(area_m2 / (kApart_m * kApart_m)));
  }

  // Adds the part of a wall, between two heights above its reference point, that faces the sensor.
  std::vector<std::uint32_t> AddWall(const ConeModel& wall, double low_m, double high_m) {
    const Matrix3 basis = BasisFromZ(wall.axis);
    const auto rings = std::lround((high_m - low_m) / kApart_m);
    std::vector<std::uint32_t> on;
    for (long j = 0; j <= rings; ++j) {
      const double height_m =
          low_m + static_cast<double>(j) / static_cast<double>(rings) * (high_m - low_m);
      const double radius_m = wall.RadiusAt_m(height_m);
      for (double turn_rad = 0; turn_rad < 2 * std::numbers::pi; turn_rad += kApart_m / radius_m) {
        const Vector3 outward =
            std::cos(turn_rad) * basis.col(0) + std::sin(turn_rad) * basis.col(1);
        const Vector3 p = wall.point + height_m * wall.axis + radius_m * outward;
        const Vector3 n = wall.FacingSign() * wall.Normal(p);
        if (n.dot(points_.viewpoint - p) > 0) on.push_back(AddPoint(p, n));
      }
    }
    return on;
  }

  ShapeFit Fit(const AnyModel& model, std::vector<std::uint32_t> inliers) const {
    ShapeFit fit;
    fit.model = model;
    fit.covered = inliers;
    fit.inliers = std::move(inliers);
    const auto count = static_cast<Eigen::Index>(ParameterCount(model));
    fit.covariance = kFitSigma * kFitSigma * Eigen::MatrixXd::Identity(count, count);
    return fit;
  }

  // The context of all points so far; valid until more are added.
  FitContext Context(const Ground& ground = {}, const FreeRays& free = {}) {
    connectivity_.emplace(points_);
    return {points_, octree_, *connectivity_, noise_, options, work_, ground, free};
  }

  std::size_t size() const { return points_.size(); }

  ModelerOptions options;

 private:
  ModelPoints points_;
  const Octree octree_{ModelPoints()};  // solids do not use it
  std::optional<Connectivity> connectivity_;
  const SensorNoise noise_;
  const Work work_;
};

}  // namespace cwm::perception
