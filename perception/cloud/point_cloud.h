// A cloud as it came from the sensor.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <vector>

#include "collision/geometry/pose.h"

namespace cwm::perception {

// Points in the sensor's (camera's) frame C, metres. Non-finite points mean "no return" and are
// kept, so that index i is always the i-th point that was sent. Organised clouds are row-major
// images seen from the origin of C.
struct PointCloud {
  std::vector<Eigen::Vector3f> points;
  std::vector<Eigen::Vector3f>
      normals;     // empty, or one per point; non-finite or zero where unknown
  int width = 0;   // width of an organised cloud; else points.size()
  int height = 1;  // 1: not organised
  // False: the places that points were seen from are unknown, as in maps and merged views. Points
  // then say nothing about the space before them, and the rows of an image are not used.
  bool seen_from_origin = true;

  std::size_t size() const { return points.size(); }
  bool organised() const { return height > 1; }
};

}  // namespace cwm::perception
