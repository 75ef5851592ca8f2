// Small planes at places all over a cloud, which show how much points scatter and what normals the
// cloud's surfaces have.
#pragma once

#include <cstdint>
#include <vector>

#include "perception/cloud/oriented_points.h"

namespace cwm::perception {

struct LocalPlane {
  std::uint32_t middle = 0;  // index of the point at the middle of the patch
  Vector3 normal = Vector3::UnitZ();
  double scatter_m = 0;  // rms of the neighbours about the plane along the sensor's ray
  bool is_flat = false;  // no thicker than a third of its width
};

// Returns planes at places spread over the cloud's order, without those seen edge on. Takes less
// than a millisecond for clouds of any size: neighbours are searched among a subset of the points.
std::vector<LocalPlane> SampleLocalPlanes(const OrientedPoints& points);

}  // namespace cwm::perception
