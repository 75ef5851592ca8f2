// The point of a simplex of one to four vertices nearest to the origin: the inner step of GJK.
#pragma once

#include <array>

#include "collision/geometry/pose.h"

namespace cwm::collision {

// The feature of a simplex that contains its point nearest to the origin.
struct SimplexFeature {
  std::array<int, 4> index = {0, 1, 2, 3};  // corners of the feature; the first `count` are valid
  std::array<double, 4> weight = {1, 0, 0, 0};
  int count = 1;
  Vector3 nearest = Vector3::Zero();
  double distance_squared = 0;
};

// The feature nearest to the origin, with `count` in 1..4. A feature of all four corners means that
// the origin is inside. Simplices without area or volume are treated as their faces and edges, so
// there is no singular case.
SimplexFeature NearestToOrigin(const std::array<Vector3, 4>& corners, int count);

}  // namespace cwm::collision
