#include "perception/cloud/sensor_noise.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "perception/cloud/point_cloud.h"
#include "perception/cloud/tolerances.h"

namespace cwm::perception {
namespace {

// cited: the focal length of the Kinect's depth image of 640 x 480 pixels.
constexpr double kKinectFocal_px = 525;
// derived: float coordinates are hardly finer than this at one metre, and no camera is as precise
// within its range.
constexpr double kMinNoise_m = 1e-5;
constexpr double kHalfPi = std::numbers::pi / 2;
// chosen: no sensor returns a point beyond this angle. Nguyen's terms diverge at grazing incidence.
constexpr double kMaxIncidence_rad = 85 * kDegree;
const double kSteepIncidence_rad = std::acos(kSteepIncidence_cos);

double Clamped(double incidence_rad) {
  return std::clamp(std::abs(incidence_rad), 0.0, kMaxIncidence_rad);
}

double KinectAxialSigma_m(double z, double incidence_rad) {
  const double theta = Clamped(incidence_rad);
  double sigma = 0.0012 + 0.0019 * (z - 0.4) * (z - 0.4);
  if (theta > kSteepIncidence_rad) {
    const double ratio = theta / (kHalfPi - theta);
    sigma += 0.0001 / std::sqrt(std::max(z, 0.1)) * ratio * ratio;
  }
  return sigma;
}

double KinectLateralSigma_m(double z, double incidence_rad) {
  const double theta = Clamped(incidence_rad);
  return (0.8 + 0.035 * theta / (kHalfPi - theta)) * z / kKinectFocal_px;
}

// A view 90 degrees wide: f = (W / 2) / tan 45 degrees.
double RealSenseFocal_px(int image_width_px) { return std::max(1.0, image_width_px / 2.0); }

}  // namespace

double SensorNoise::AxialSigma_m(double depth_m, double incidence_rad) const {
  const double z = std::max(depth_m, 0.0);
  switch (model) {
    case SensorModel::kKinect:
      return KinectAxialSigma_m(z, incidence_rad);
    case SensorModel::kRealSense:
      return std::max(kMinNoise_m, z * z * 0.1 / (RealSenseFocal_px(image_width_px) * 0.05));
    case SensorModel::kTimeOfFlight:
      return std::max(kMinNoise_m, 0.01 * z);
    case SensorModel::kTiltingLaser:
      return std::max(0.018, 0.0015 + 0.0006 * z);
    case SensorModel::kSickLms400:
      return 0.0065;
    case SensorModel::kGiven:
      break;
  }
  return std::max(kMinNoise_m, given_sigma_m + given_quadratic_per_m * z * z);
}

double SensorNoise::LateralSigma_m(double depth_m, double incidence_rad) const {
  const double z = std::max(depth_m, 0.0);
  switch (model) {
    case SensorModel::kKinect:
      return KinectLateralSigma_m(z, incidence_rad);
    case SensorModel::kRealSense:
      // Half a pixel, the resolution of block matching.
      return 0.5 * z / RealSenseFocal_px(image_width_px);
    case SensorModel::kTimeOfFlight:
      return 0.5 * z / kKinectFocal_px;  // half a pixel of a sensor of similar resolution
    // 0.05 to 0.1 degrees of jitter per line; a quarter of an angular step of 0.25 degrees.
    case SensorModel::kTiltingLaser:
    case SensorModel::kSickLms400:
      return 0.001 * z;
    case SensorModel::kGiven:
      break;
  }
  return AxialSigma_m(z);
}

WorkingRange RangeOf(SensorModel model) {
  switch (model) {
    case SensorModel::kKinect:
      return {"a Kinect", 0.4, 10};
    case SensorModel::kRealSense:
      return {"a RealSense", 0.1, 20};
    case SensorModel::kTimeOfFlight:
      return {"a time of flight camera", 0.1, 20};
    case SensorModel::kTiltingLaser:
      return {"a tilting laser", 0.1, 60};
    case SensorModel::kSickLms400:
      return {"a SICK LMS400", 0.1, 10};
    case SensorModel::kGiven:
      break;
  }
  return {"a sensor of that sigma", 0, kWidestMap_m};
}

SensorNoise NoiseIn(const PointCloud& cloud, SensorNoise noise) {
  if (cloud.organised()) noise.image_width_px = cloud.width;
  return noise;
}

bool Triangulates(SensorModel model) {
  return model == SensorModel::kKinect || model == SensorModel::kRealSense;
}

PlaneSpread SensorNoise::SpreadAboutPlanes() const {
  switch (model) {
    case SensorModel::kKinect:
      return {.wide = 12, .usual = 6};
    case SensorModel::kRealSense:
      return {.wide = 6, .usual = 4};
    case SensorModel::kTimeOfFlight:
    case SensorModel::kGiven:
      return {.wide = 4.5F, .usual = 3.5F};
    case SensorModel::kTiltingLaser:
    case SensorModel::kSickLms400:
      return {.wide = 3, .usual = 3};
  }
  return {};
}

double SensorNoise::PointsPerSample() const {
  const bool is_laser = model == SensorModel::kTiltingLaser || model == SensorModel::kSickLms400;
  return is_laser ? 1 : kPointsPerIndependentSample;
}

double SensorNoise::WarpSigma_m() const {
  const double of_sensor_m = Triangulates(model)                   ? kSlowWarp_m
                             : model == SensorModel::kTimeOfFlight ? kMultipath_m
                                                                   : 0;
  return std::hypot(of_sensor_m, registration_sigma_m);
}

}  // namespace cwm::perception
