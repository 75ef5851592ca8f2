// Noise models of range sensors. The thresholds of perception that depend on noise follow from
// them, and the virtual scanner draws its noise from them.
#pragma once

#include <algorithm>
#include <string_view>

#include "collision/geometry/pose.h"

namespace cwm::perception {

struct PointCloud;

enum class SensorModel { kKinect, kRealSense, kTimeOfFlight, kTiltingLaser, kSickLms400, kGiven };

// True for depth cameras that measure range by triangulation; their errors also have a slow warp.
bool Triangulates(SensorModel model);

// The distance from its plane at which a sensor shows points of a flat surface, in standard
// deviations of the range. Three of them are noise; the rest varies slowly across an image: warp,
// distortion of the lens, calibration of depth.
struct PlaneSpread {
  float wide = 12;  // corners of a Kinect's image: 15 mm at 0.6 m, on 45 scans of tables
  float usual = 6;  // half of the largest by noise and warp; higher points are objects
};

struct SensorNoise {
  SensorModel model = SensorModel::kKinect;
  double given_sigma_m = 0.002;      // used by kGiven only; at least 1e-5
  double given_quadratic_per_m = 0;  // used by kGiven only; at least 0
  int image_width_px = 640;          // used by kRealSense only; see NoiseIn
  double registration_sigma_m = 0;   // for views merged in one cloud; see kRegistration_m

  // One standard deviation along the ray, metres, at depth z (distance along the optical axis) and
  // incidence angle theta (between ray and surface normal).
  //   kKinect        0.0012 + 0.0019 (z - 0.4)^2; beyond 60 degrees
  //                  + 0.0001 / sqrt(z) theta^2 / (pi/2 - theta)^2 (Nguyen, Izadi and Lovell 2012)
  //   kRealSense     0.1 pixel of disparity at image_width_px over 90 degrees and 50 mm baseline
  //   kTimeOfFlight  0.01 z
  //   kTiltingLaser  max(0.018, 0.0015 + 0.0006 range), Hokuyo UTM-30LX
  //   kSickLms400    0.0065, between 0.003 on bright and 0.010 on dark surfaces
  //   kGiven         given_sigma_m + given_quadratic_per_m z^2
  double AxialSigma_m(double depth_m, double incidence_rad = 0) const;

  // One standard deviation across the ray, metres (Kinect: 0.8 + 0.035 theta / (pi/2 - theta)
  // pixels, f = 525).
  double LateralSigma_m(double depth_m, double incidence_rad = 0) const;

  // One standard deviation along the ray of the error that points within a hand's breadth share,
  // metres: kSlowWarp_m for depth cameras that triangulate, kMultipath_m for time of flight, 0 for
  // all others; plus the error of the registration.
  double WarpSigma_m() const;

  // The number of neighbouring points that carry the information of one with an independent error:
  // kPointsPerIndependentSample, but 1 for lasers, whose beams err independently. Normals, the
  // criterion of the refinement and some of its splits use it; fits always use
  // kPointsPerIndependentSample.
  double PointsPerSample() const;

  // The spread of this sensor. A RealSense, with some three times the noise of a Kinect, adds as
  // many millimetres to the noise; sensors that do not triangulate add half of their noise's reach
  // for their bias; lasers, whose beams err independently, add nothing.
  PlaneSpread SpreadAboutPlanes() const;
};

// The least and greatest range of a sensor, metres.
struct WorkingRange {
  const char* sensor;  // "a Kinect"
  double nearest_m, farthest_m;
};
WorkingRange RangeOf(SensorModel model);

// The noise model with the image width of an organised cloud; unchanged for other clouds. An
// organised cloud is assumed to be a whole image, because the width that it may have been cropped
// from is unknown.
SensorNoise NoiseIn(const PointCloud& cloud, SensorNoise noise);

// measured: the rms of the slow warp of depth cameras that triangulate, on the tables of real
// Kinect scans; errors of points nearer than a quarter of 0.2 m are correlated.
inline constexpr double kSlowWarp_m = 0.0013;
// measured: time of flight measures too long where surfaces light each other: by 3.5 mm in the mean
// and 4 to 8 mm rms for objects on a table in simulated scenes (albedo 0.5), more for smaller
// objects.
inline constexpr double kMultipath_m = 0.005;
// cited: views merged in one cloud disagree by 2 to 5 mm and 0.2 to 0.5 degrees, as much as ICP
// leaves between scans of a room; no cloud states by how much.
inline constexpr double kRegistration_m = 0.003;
// derived: the warps of two points d apart correlate like exp(-d^2 / (2 l^2)) with this l, which
// has the curvature at d = 0 of waves of 0.2 to 0.6 m, all equally likely.
inline constexpr double kWarpCorrelation_m = 0.078;

// chosen: the largest distance of points from the origin of a map. Maps merged of many views have
// their origin anywhere in a building.
inline constexpr double kWidestMap_m = 100;

// chosen: this many standard deviations hold all but 0.3 % of independent errors.
inline constexpr double kGate_sigma = 3;

// chosen: a surface explains a point, and collision checking with it is safe, within max(10 mm, 3
// sigma). This is the only measure of coverage, for all kinds of surfaces.
inline constexpr double kExplainedWithin_m = 0.010;
inline constexpr double ExplainedWithin_m(double sigma_m) {
  return std::max(kExplainedWithin_m, kGate_sigma * sigma_m);
}

// cited: the cosine of the incidence of 60 degrees, beyond which an extra term raises the noise
// (Nguyen, Izadi and Lovell 2012).
inline constexpr double kSteepIncidence_cos = 0.5;

// measured: neighbouring residuals are correlated (mOSD tables: 0.72 / 0.59 / 0.39 / 0.11 at 1 / 2
// / 4 / 8 pixels along rows), so n points carry the information of n / kPointsPerIndependentSample.
inline constexpr double kPointsPerIndependentSample = 12;

}  // namespace cwm::perception
