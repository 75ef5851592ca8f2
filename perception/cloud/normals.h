// Surface normals (paper, section III step 1) whose neighbourhood depends on the noise of the
// sensor.
#pragma once

#include <cstddef>
#include <numbers>

#include "perception/cloud/measured_points.h"
#include "perception/cloud/voxel_grid.h"
#include "perception/cloud/work.h"

namespace cwm::perception {

// A neighbourhood of radius r has an error from noise, 2 sigma s / (sqrt(pi) r^2) for points s
// apart with independent errors, and an error from curvature, r / R. Their sum is least for r^3 = 4
// R sigma s / sqrt(pi).
// chosen: R is about that of the largest objects for a table; with it the radius of a Kinect at up
// to 1.2 m follows from the limit below.
inline constexpr float kNormalBend_m = 0.11f;
// measured: the largest radius in standard deviations of the range. Below 6 the normals of a Kinect
// scatter by more than 10 degrees, above 8 creases blur. On an image the radius is at least two
// pixels.
inline constexpr float kNormalRadius_sigma = 7;

float NormalRadius_m(float sigma_m, float spacing_m);

// derived: the standard deviation of an unknown normal, a right angle.
inline constexpr float kUnknownSigma_rad = std::numbers::pi_v<float> / 2;

// One standard deviation of a normal's angle from n points with independent errors spread over
// radius r.
float NormalSigma_rad(float sigma_m, float radius_m, float sample_count);

// Both functions set `normals` where they are zero, and normal_sigma_rad everywhere. They fit the
// plane nearest to the neighbours along the sensor's ray, which is the direction of the noise.
// Points farther away than the radius do not count, so no neighbourhood reaches across a depth jump
// of 3 sigma + 1 cm. All normals, given ones included, are turned toward the sensor at the origin.
// A normal stays zero if fewer than three neighbours, or neighbours on a line, leave it undefined.

// For organised clouds: windows on the image.
void EstimateImageNormals(MeasuredPoints& measured, const Work& work);

// For any cloud: from the sums of the cells around each cell. Points share the normal of their
// cell.
void EstimateGridNormals(OrientedPoints& points, const VoxelGrid& grid, float radius_m,
                         const Work& work);

}  // namespace cwm::perception
