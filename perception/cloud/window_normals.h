// The inner loop of normals on an image: planes fitted in windows, eight pixels at once.
#pragma once

#include <vector>

#include "perception/cloud/image_plane.h"

namespace cwm::perception {

// The points of an image.
struct PointPlanes {
  int width = 0, height = 0;
  float pixel_angle_rad = 0;
  float sample_px = 1;  // between pixels that err each by itself
  ImagePlane x, y, z;   // metres, the sensor at the origin
  ImagePlane sigma_m;
};

// One entry per pixel of a row, and a few more that say nothing.
struct RowNormals {
  std::vector<float> x, y, z;    // unit, towards the sensor; zero where unknown
  std::vector<float> sigma_rad;  // NormalSigma_rad of the points that were found

  explicit RowNormals(int width);
};

// For each pixel the plane nearest to its neighbours along its ray (see normals.h): of 7 x 7 pixels
// or fewer that span the radius, or as many as err each by itself, those count that lie as near as the
// noise of such a window reaches, since at a grazing view a window reaches farther than the radius. Where noise is small beside the distance of
// pixels, the radius is two pixels, and neighbours count up to twice as far away. Entries without a
// point are undefined.
void EstimateRow(const PointPlanes& points, int row, RowNormals& normals);

}  // namespace cwm::perception
