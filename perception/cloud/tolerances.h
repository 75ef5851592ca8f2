// Tolerances that mean the same wherever perception asks: of shares, lengths, angles and counts. What one
// stage alone asks for stands where it is asked.
#pragma once

#include <cstddef>
#include <numbers>

#include "perception/cloud/sensor_noise.h"

namespace cwm::perception {

// Shares of the points of a piece or an object.

// measured: what one surface explains of what is nothing else; the rest are mixed pixels and edges.
inline constexpr double kNearlyAll = 0.9;
// chosen: what most points must have in common where surfaces hide or touch each other.
inline constexpr double kMainShare = 0.8;
// chosen: the larger part, of points, of an outline or of an area.
inline constexpr double kLargerPart = 0.5;
// chosen: a part that mixed pixels and chance do not make, where most is hidden or turned away.
inline constexpr double kNotByChance = 0.2;
// measured: quantiles of heights beyond which mixed pixels lie, on real scans of tables.
inline constexpr double kMixedPixels = 0.02;
// measured: rays that seem to pass a surface are mixed pixels at its edges, up to this share.
inline constexpr double kMaxPassing = 0.05;

// Counts of measured points, by what so many of a Kinect's tell.

inline constexpr std::size_t kOneSample = static_cast<std::size_t>(kPointsPerIndependentSample);
inline constexpr std::size_t kTwoSamples = kOneSample * 2;    // show that there is a surface
inline constexpr std::size_t kThreeSamples = kOneSample * 3;  // fix a plane
inline constexpr std::size_t kFiveSamples = kOneSample * 5;   // show a shape, or a side of one

// Lengths, in metres.

// measured: how well noise and warp let the height of a support, or of what lies on it, be known.
inline constexpr double kGroundNoise_m = 0.003;
// derived: four standard deviations, of a Kinect at 0.8 m and of any sensor: noise alone is less.
inline constexpr double kNoiseReach_m = 0.006, kNoiseReach_sigma = 4;
// cited: the leaves of the paper's octree, of which footprints are made (section IV, figure 5).
inline constexpr double kFootprintCell_m = 0.01;
// measured: what mixed pixels and the normal gate take from the edges of faces.
inline constexpr double kEdgeLoss_m = 0.025;
// chosen: between objects that touch: a wall, its rim's shadow, and noise on either side.
inline constexpr double kTouching_m = 0.03;
// chosen: a vessel's wall with the roundness of its rim, and how far the heights of its rims differ.
inline constexpr double kVesselWall_m = 0.015, kVesselRim_m = 0.02;
// chosen: the largest radius of a vessel for a table.
inline constexpr double kWidestVessel_m = 0.3;
// chosen: between the parts of an object for a table that something hides in part.
inline constexpr double kWidestHidden_m = 0.35;
// chosen: to which points are thinned: two to three pixels of a Kinect at 0.8 m.
inline constexpr double kThinnedTo_m = 0.004;
// chosen: finer than the noise of any range sensor.
inline constexpr double kBelowNoise_m = 0.0005;
// chosen: of cardboard; a box needs some volume.
inline constexpr double kThinnest_m = 0.002;

// Angles.

inline constexpr double kDegree = std::numbers::pi / 180;
// measured: what is nearer to upright is upright, by the noise of the normal of a face of 60 points.
inline constexpr double kUprightWithin_rad = 3 * kDegree;
// cited: between normals of one surface (the paper's constraint on n_i . n_j, as printed).
inline constexpr double kSameNormal_rad = 15 * kDegree;
// derived: three standard deviations of the normals of a Kinect, 17 degrees, as a sine.
inline constexpr double kNormalMiss_sin = 0.3;
// derived: the horizontal part of a normal that tells a direction, 20 degrees from upright.
inline constexpr double kSteep_sin = 0.35;
// chosen: of the angle between a ray and a surface, 20 degrees: below, sensors begin to lose points.
inline constexpr double kGrazing_sin = 0.34;
// chosen: a wall that is nearer to upright than to level, 30 degrees, as the sine of its normal's rise.
inline constexpr double kWallRise_sin = 0.5;

// chosen: of 15 degrees around an axis: what stands out from a wall fills two or three.
inline constexpr int kSectors = 24;

// Numerical derivatives of lengths and angles, in metres and radians.
inline constexpr double kDerivativeStep = 1e-6;

}  // namespace cwm::perception
