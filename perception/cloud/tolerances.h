// Tolerances that all of perception shares: shares, lengths, angles and counts. A tolerance of a
// single stage is defined in that stage.
#pragma once

#include <cstddef>
#include <numbers>

#include "perception/cloud/sensor_noise.h"

namespace cwm::perception {

// Shares of the points of a segment or an object.

// measured: the share of a segment that its only surface explains; the rest are mixed pixels and
// edges.
inline constexpr double kNearlyAll = 0.9;
// chosen: the share of points that must agree where surfaces occlude or touch each other.
inline constexpr double kMainShare = 0.8;
// chosen: the larger part of points, of an outline or of an area.
inline constexpr double kMajority = 0.5;
// chosen: a share that mixed pixels and chance do not reach, where most is occluded or faces away.
inline constexpr double kMinSignificantShare = 0.2;
// measured: the quantiles of heights beyond which mixed pixels lie, on real scans of tables.
inline constexpr double kMixedPixels = 0.02;
// measured: up to this share of the rays that seem to pass a surface are mixed pixels at its edges.
inline constexpr double kMaxPassing = 0.05;

// Counts of measured points, by what that many points of a Kinect establish.

inline constexpr std::size_t kOneSample = static_cast<std::size_t>(kPointsPerIndependentSample);
inline constexpr std::size_t kTwoSamples = kOneSample * 2;    // show that there is a surface
inline constexpr std::size_t kThreeSamples = kOneSample * 3;  // determine a plane
inline constexpr std::size_t kFiveSamples = kOneSample * 5;   // show a shape, or a side of one

// Lengths, in metres.

// measured: the accuracy to which noise and warp let the height of a support, or of an object on
// it, be known.
inline constexpr double kGroundNoise_m = 0.003;
// derived: four standard deviations, for a Kinect at 0.8 m and for any sensor; noise alone is less.
inline constexpr double kNoiseReach_m = 0.006, kNoiseReach_sigma = 4;
// cited: the leaves of the paper's octree, of which footprints are made (section IV, figure 5).
inline constexpr double kFootprintCell_m = 0.01;
// measured: the width that mixed pixels and the normal gate remove from the edges of faces.
inline constexpr double kEdgeLoss_m = 0.025;
// chosen: the gap between objects that touch: a wall, the shadow of its rim, and noise on either
// side.
inline constexpr double kMaxTouchingGap_m = 0.03;
// chosen: a vessel's wall with the roundness of its rim, and the difference between the heights of
// its rims.
inline constexpr double kVesselWall_m = 0.015, kVesselRim_m = 0.02;
// chosen: the largest radius of a vessel for a table.
inline constexpr double kMaxVesselRadius_m = 0.3;
// chosen: the largest gap between the visible parts of a partly occluded object for a table.
inline constexpr double kMaxHiddenGap_m = 0.35;
// chosen: the spacing to which points are thinned: two to three pixels of a Kinect at 0.8 m.
inline constexpr double kThinningSpacing_m = 0.004;
// chosen: finer than the noise of any range sensor.
inline constexpr double kSubNoise_m = 0.0005;
// chosen: the thickness of cardboard; a box needs some volume.
inline constexpr double kMinThickness_m = 0.002;

// Angles.

inline constexpr double kDegree = std::numbers::pi / 180;
// measured: a direction this near to upright is upright; the normal of a face of 60 points is as
// noisy.
inline constexpr double kUprightWithin_rad = 3 * kDegree;
// cited: the largest angle between normals of one surface (the paper's constraint on n_i . n_j, as
// printed).
inline constexpr double kSameNormal_rad = 15 * kDegree;
// derived: three standard deviations of the normals of a Kinect, 17 degrees, as a sine.
inline constexpr double kNormalMiss_sin = 0.3;
// derived: the least horizontal part of a normal that shows a direction, 20 degrees from upright.
inline constexpr double kSteep_sin = 0.35;
// chosen: the sine of the angle between a ray and a surface, 20 degrees, below which sensors begin
// to lose points.
inline constexpr double kGrazing_sin = 0.34;
// chosen: the sine of the elevation of a wall's normal, 30 degrees; a wall of less is nearer to
// upright than to level.
inline constexpr double kWallRise_sin = 0.5;

// chosen: sectors of 15 degrees around an axis; a part that stands out from a wall fills two or
// three.
inline constexpr int kSectors = 24;

// The step of numerical derivatives of lengths and angles, in metres and radians.
inline constexpr double kDerivativeStep = 1e-6;

}  // namespace cwm::perception
