// The corners of a hull in arrays, so that many are compared at once.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "collision/geometry/pose.h"

namespace cwm::collision {

// Immutable.
class VertexLanes {
 public:
  // At least one vertex.
  explicit VertexLanes(std::span<const Vector3> vertices);

  // The first of those that lie farthest in a direction, to the bit what a plain loop finds: no
  // product is fused with a sum, whatever the machine. Any direction will do, by length as well.
  std::size_t Farthest(const Vector3& d) const;

  // Below, a plain loop is as fast (measured at 8 lanes).
  static constexpr std::size_t kFewest = 12;

 private:
  std::size_t stride_;               // a multiple of the lanes of every machine
  std::vector<double> coordinates_;  // x of all, y of all, z of all; the first vertex fills up
};

}  // namespace cwm::collision
