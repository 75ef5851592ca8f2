// Noise of range sensors: every threshold of perception follows from it, and the virtual scanner
// draws from it.
#pragma once

#include <algorithm>
#include <string_view>

#include "collision/geometry/pose.h"

namespace cwm::perception {

struct PointCloud;

enum class SensorModel {
  kKinect,
  kRealSense,
  kTimeOfFlight,
  kTiltingLaser,
  kSickLms400,
  kConstant
};

// Depth cameras that find range by triangulation, whose errors warp slowly besides.
bool Triangulates(SensorModel model);

// How far from its plane a sensor shows places of a flat surface, in standard deviations of the
// range: three by noise, the rest by what is slow across an image, warp, distortion of the lens,
// calibration of depth.
struct PlaneSpread {
  float most = 12;  // the corners of a Kinect's view: 15 mm at 0.6 m, on 45 scans of tables
  float usual = 6;  // half of the largest by noise and warp: what rises more is a thing of its own
};

struct SensorNoise {
  SensorModel model = SensorModel::kKinect;
  double constant_sigma_m = 0.002;  // used by kConstant alone; less than 1e-5 counts as that
  int image_width_px = 640;         // used by kRealSense alone: see NoiseIn
  double registration_sigma_m = 0;  // of views that are joined in one cloud: see kRegistration_m

  // One standard deviation along the ray, metres, at depth z (distance along the optical axis) and
  // incidence angle theta (between ray and surface normal).
  //   kKinect        0.0012 + 0.0019 (z - 0.4)^2; beyond 60 degrees
  //                  + 0.0001 / sqrt(z) theta^2 / (pi/2 - theta)^2 (Nguyen, Izadi and Lovell 2012)
  //   kRealSense     0.1 pixel of disparity at image_width_px over 90 degrees and 50 mm baseline
  //   kTimeOfFlight  0.01 z
  //   kTiltingLaser  max(0.018, 0.0015 + 0.0006 range), Hokuyo UTM-30LX
  //   kSickLms400    0.0065, between 0.003 on bright and 0.010 on dark surfaces
  double AxialSigma_m(double depth_m, double incidence_rad = 0) const;

  // One standard deviation across the ray, metres (Kinect: 0.8 + 0.035 theta / (pi/2 - theta)
  // pixels, f = 525).
  double LateralSigma_m(double depth_m, double incidence_rad = 0) const;

  // One standard deviation along the ray of what errs alike over a hand's breadth, metres: kSlowWarp_m
  // for depth cameras that triangulate, kMultipath_m for time of flight, 0 for all others; and the
  // registration's besides.
  double WarpSigma_m() const;

  // So many neighbouring points carry the information of one that errs by itself:
  // kPointsPerIndependentSample, but of lasers, whose beams err one by one, 1. Normals ask alone.
  double PointsPerSample() const;

  // Of a RealSense, whose noise is some three times a Kinect's, as many millimetres besides noise; of
  // sensors that do not triangulate half of their noise's reach for what their bias does; of lasers,
  // whose beams err one by one, noise alone.
  PlaneSpread SpreadAboutPlanes() const;
};

// The noise with the width of the image that an organised cloud is; as it was for any other. Images
// are taken for whole ones: of a part that was cut out nobody says how wide the whole was.
SensorNoise NoiseIn(const PointCloud& cloud, SensorNoise noise);

// measured: how much depth cameras that triangulate warp slowly besides, rms, on the tables of real
// Kinect scans, where points nearer than a quarter of 0.2 m err together.
inline constexpr double kSlowWarp_m = 0.0013;
// measured: time of flight is long where surfaces light each other, by 3.5 mm in the mean and 4 to
// 8 mm rms for objects on a table in simulated scenes (albedo 0.5), the smaller the more.
inline constexpr double kMultipath_m = 0.005;
// cited: views that are registered with each other in one cloud do not quite fit, by 2 to 5 mm and
// 0.2 to 0.5 degrees, as much as ICP leaves between scans of a room; nobody tells by how much.
inline constexpr double kRegistration_m = 0.003;
// derived: the warps of two points d apart correlate like exp(-d^2 / (2 l^2)) with this l, which
// has the curvature at d = 0 of waves of 0.2 to 0.6 m, all equally likely.
inline constexpr double kWarpCorrelation_m = 0.078;

// chosen: so many standard deviations hold what errs by noise alone, but for 0.3 % of it.
inline constexpr double kGate_sigma = 3;

// chosen: a surface explains a point, and collision checking with it is safe, within
// max(10 mm, 3 sigma): the one measure of coverage, whatever surface it is.
inline constexpr double kExplainedWithin_m = 0.010;
inline constexpr double ExplainedWithin_m(double sigma_m) {
  return std::max(kExplainedWithin_m, kGate_sigma * sigma_m);
}

// cited: of incidence; beyond 60 degrees noise grows by its own term (Nguyen, Izadi and Lovell
// 2012).
inline constexpr double kSteepIncidence_cos = 0.5;

// measured: neighbouring residuals are correlated (mOSD tables: 0.72 / 0.59 / 0.39 / 0.11 at 1 / 2
// / 4 / 8 pixels along rows), so n points carry the information of n / kPointsPerIndependentSample.
inline constexpr double kPointsPerIndependentSample = 12;

}  // namespace cwm::perception
