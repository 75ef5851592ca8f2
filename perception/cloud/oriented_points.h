// Finite points with normals, in one frame: the interpreter's input to the modeler.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "collision/geometry/pose.h"
#include "perception/cloud/sensor_noise.h"

namespace cwm::perception {

// chosen: the unevenness of tables and boards; the noise of precise sensors is less.
inline constexpr float kUnevenness_m = 0.001f;

// Structure of arrays, all of one length. The frame is the level frame L (z up, the sensor at the
// origin or at `viewpoint`) unless said otherwise.
struct OrientedPoints {
  std::vector<Eigen::Vector3f> points;     // metres
  std::vector<Eigen::Vector3f> normals;    // unit, towards the sensor; zero where unknown
  std::vector<float> sigma_m;              // one standard deviation of the range noise at the point
  std::vector<float> normal_sigma_rad;     // one standard deviation of the normal's angle
  std::vector<std::uint32_t> cloud_index;  // index of the point in the PointCloud
  Vector3 viewpoint = Vector3::Zero();     // position of the sensor
  PlaneSpread spread = {};                 // of the sensor's points about planes
  // SensorNoise::PointsPerSample of the sensor.
  float points_per_sample = static_cast<float>(kPointsPerIndependentSample);
  float warp_m = 0;  // SensorNoise::WarpSigma_m of the sensor

  std::size_t size() const { return points.size(); }

  // The largest and the usual distance of a support's point from the support's plane, in metres.
  float WidePlaneTolerance_m(std::size_t i) const {
    return PlaneTolerance_m(spread.wide, sigma_m[i]);
  }
  float UsualPlaneTolerance_m(std::size_t i) const {
    return PlaneTolerance_m(spread.usual, sigma_m[i]);
  }
  static float PlaneTolerance_m(float spread_sigma, float sigma_m) {
    return std::max(kUnevenness_m, spread_sigma * sigma_m);
  }
};

// The listed points, in the order of the list.
OrientedPoints Subset(const OrientedPoints& all, std::span<const std::uint32_t> members);

}  // namespace cwm::perception
