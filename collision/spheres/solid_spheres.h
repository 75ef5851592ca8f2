// Spheres around a solid, and spheres within it.
#pragma once

#include <vector>

#include "collision/geometry/shape.h"

namespace cwm::collision {

struct Ball {
  Vector3 centre = Vector3::Zero();
  double radius_m = 0;
};

struct SolidSpheres {
  std::vector<Ball> around;  // together they contain the shape, of a mesh its bounding box
  std::vector<Ball> within;  // each lies in the shape; none in a mesh
  bool is_exact = false;     // true of a sphere, which `around` is alone
};

// At most 27 spheres of either kind, in the frame O of the pose. Of a half-space none, which no
// sphere contains. Takes a microsecond, for plates and hulls the time of as many signed distances.
SolidSpheres SpheresOf(const Shape& shape, const Pose& X_OS);

}  // namespace cwm::collision
