// The inner loop of normals on an image: fits planes in windows, eight pixels at once.
#pragma once

#include <vector>

#include "perception/cloud/image_plane.h"

namespace cwm::perception {

// The points of an image.
struct PointPlanes {
  int width = 0, height = 0;
  float pixel_angle_rad = 0;
  float sample_px = 1;  // distance between pixels with independent errors
  ImagePlane x, y, z;   // metres, the sensor at the origin
  ImagePlane sigma_m;
};

// One entry per pixel of a row, and a few more without meaning.
struct RowNormals {
  std::vector<float> x, y, z;    // unit, towards the sensor; zero where unknown
  std::vector<float> sigma_rad;  // NormalSigma_rad of the points that were found

  explicit RowNormals(int width);
};

// Fits for each pixel of a row the plane that is nearest to its neighbours along its ray (see
// normals.h). The neighbours are 7 x 7 pixels or fewer that span the radius, or more if pixels err
// independently. A neighbour counts if it lies as near as the noise of such a window reaches, since
// at a grazing view a window extends beyond the radius. If the noise is small compared with the
// distance of pixels, the radius is two pixels, and neighbours count up to twice as far away.
// Entries without a point are undefined.
void EstimateRow(const PointPlanes& points, int row, RowNormals& normals);

}  // namespace cwm::perception
