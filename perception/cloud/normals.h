// Surface normals (paper, section III step 1) whose neighbourhood follows the noise of the sensor.
#pragma once

#include <cstddef>
#include <numbers>

#include "perception/cloud/measured_points.h"
#include "perception/cloud/voxel_grid.h"
#include "perception/cloud/work.h"

namespace cwm::perception {

// A neighbourhood of radius r errs by noise, 2 sigma s / (sqrt(pi) r^2) of points s apart that err each
// by itself, and by what bends within it, r / R: least for r^3 = 4 R sigma s / sqrt(pi).
// chosen: R is about that of the largest objects for a table; with it the radius of a Kinect at up
// to 1.2 m follows from the limit below.
inline constexpr float kNormalBend_m = 0.11f;
// measured: at most so many standard deviations of the range. Below 6 the normals of a Kinect
// scatter by more than 10 degrees, above 8 creases wash out. Of an image no less than two pixels.
inline constexpr float kNormalRadius_sigma = 7;

float NormalRadius_m(float sigma_m, float spacing_m);

// derived: of a normal that nothing tells, a right angle.
inline constexpr float kUnknownSigma_rad = std::numbers::pi_v<float> / 2;

// One standard deviation of a normal's angle from n points spread over radius r that err each by
// itself.
float NormalSigma_rad(float sigma_m, float radius_m, float sample_count);

// Both fill in `normals` where they are zero, and normal_sigma_rad everywhere: the plane that is
// nearest to the neighbours along the sensor's ray, where the noise is. Points farther away than
// the radius do not count, so that no neighbourhood reaches across a depth jump of 3 sigma + 1 cm.
// All normals, given ones too, are turned to the sensor at the origin. A normal stays zero where
// fewer than three neighbours or neighbours on a line leave it undefined.

// For organised clouds: windows on the image.
void EstimateImageNormals(MeasuredPoints& measured, const Work& work);

// For any cloud: from the sums of the cells around each cell; points share the normal of their
// cell.
void EstimateGridNormals(OrientedPoints& points, const VoxelGrid& grid, float radius_m,
                         const Work& work);

}  // namespace cwm::perception
