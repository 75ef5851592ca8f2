// libccd's own EPA, called directly: a referee for depths that shares no code with the kernels.
#pragma once

#include <optional>

#include "collision/geometry/shape.h"

namespace cwm::collision {

// The tolerance at which libccd's polytope stops growing.
inline constexpr double kEpaTolerance_m = 1e-6;

// A placed shape for libccd: a support function in the world.
struct LibccdBody {
  const Shape& shape;
  Pose X_WS;
};

// True for spheres, boxes, cylinders, cones, capsules, hulls, and plates without holes, whose
// outline must be convex.
bool IsKnownToLibccd(const Shape& shape);

struct LibccdDepth {
  double depth_m;
  Vector3 normal_W;  // unit, from A to B
};
// Empty if libccd finds no overlap, or returns no direction.
std::optional<LibccdDepth> LibccdPenetration(const LibccdBody& a, const LibccdBody& b);

}  // namespace cwm::collision
