// Surface normals (paper, section III step 1) whose neighbourhood follows the noise of the sensor.
#pragma once

#include <cstddef>

#include "perception/cloud/measured_points.h"
#include "perception/cloud/voxel_grid.h"
#include "perception/cloud/work.h"

namespace cwm::perception {

// The neighbourhood's radius in standard deviations of the range: below 6 the normals of a Kinect
// scatter by more than 10 degrees, above 8 creases wash out. Of an image no less than two pixels.
inline constexpr float kNormalRadius_sigma = 7;

// One standard deviation of a normal's angle from n correlated points spread over radius r.
float NormalSigma_rad(float sigma_m, float radius_m, float point_count);

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
