// libccd's own EPA, called directly: a referee of depths that shares no code with the kernels.
#pragma once

#include <optional>

#include "collision/geometry/shape.h"

namespace cwm::collision {

// Where libccd's polytope stops growing.
inline constexpr double kEpaTolerance_m = 1e-6;

// A placed shape as libccd sees it: a support function in the world.
struct LibccdBody {
  const Shape& shape;
  Pose X_WS;
};

// Spheres, boxes, cylinders, cones, capsules, hulls, and plates with a convex outline.
bool IsKnownToLibccd(const Shape& shape);

struct LibccdDepth {
  double depth_m;
  Vector3 normal_W;  // unit, from A to B
};
// Nothing where libccd sees no overlap, or tells no direction.
std::optional<LibccdDepth> AskLibccd(const LibccdBody& a, const LibccdBody& b);

}  // namespace cwm::collision
