// Small planes at places all over a cloud: how much points really scatter, and what normals they
// show.
#pragma once

#include <cstdint>
#include <vector>

#include "perception/cloud/oriented_points.h"

namespace cwm::perception {

struct LocalPlane {
  std::uint32_t middle = 0;  // index of the point whose neighbours these are
  Vector3 normal = Vector3::UnitZ();
  double scatter_m = 0;  // rms of the neighbours about the plane along the sensor's ray
  bool is_flat = false;  // no thicker than a third of its width
};

// At places spread over the cloud's order, but for those whose plane is seen edge on. Less than a
// millisecond, whatever the cloud's size: neighbours are looked for among some of the points.
std::vector<LocalPlane> SampleLocalPlanes(const OrientedPoints& points);

}  // namespace cwm::perception
