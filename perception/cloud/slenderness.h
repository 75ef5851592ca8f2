// Measures the length and the width of a cluster along its bends: the ear of a mug is as slender as
// the bar that it was made of.
#pragma once

#include <Eigen/Core>
#include <array>
#include <span>

#include "collision/geometry/pose.h"

namespace cwm::perception {

struct Slenderness {
  double length_m = 0;  // length of the longest shortest path through the cluster
  double width_m = 0;   // area seen by the sensor, divided by the length
  // The ends of that path; the origin if there are no points.
  std::array<Vector3, 2> ends{Vector3::Zero(), Vector3::Zero()};
};

// Measures one connected cluster of points, about `spacing_m` apart, seen from `viewpoint`; exact
// to a cell of max(4 mm, 2 spacings). All values are zero without points.
Slenderness MeasureSlenderness(std::span<const Eigen::Vector3f> points, const Vector3& viewpoint,
                               double spacing_m);

}  // namespace cwm::perception
