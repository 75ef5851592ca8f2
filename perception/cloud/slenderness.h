// How long and how wide a cluster is, however it is bent: the ear of a mug is as slender as the bar
// that it was made of.
#pragma once

#include <Eigen/Core>
#include <array>
#include <span>

#include "collision/geometry/pose.h"

namespace cwm::perception {

struct Slenderness {
  double length_m = 0;  // of the longest of the shortest ways through the cluster
  double width_m = 0;   // area that the sensor sees, over the length
  // Of the longest of those ways; the origin without points.
  std::array<Vector3, 2> ends{Vector3::Zero(), Vector3::Zero()};
};

// Points of one connected cluster, about `spacing_m` apart, seen from `viewpoint`. True to a cell
// of max(4 mm, 2 spacings). All are zero without points.
Slenderness MeasureSlenderness(std::span<const Eigen::Vector3f> points, const Vector3& viewpoint,
                               double spacing_m);

}  // namespace cwm::perception
