// The corners of a hull in one array per coordinate, so that SIMD compares many at once.
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

  // The index of the vertex farthest in a direction, the first one if several are equally far. The
  // same bits as a plain loop on every machine, since products and sums are not fused. `d` need not
  // be a unit vector.
  std::size_t Farthest(const Vector3& d) const;

  // measured: with fewer vertices a plain loop is as fast (at 8 SIMD lanes).
  static constexpr std::size_t kMin = 12;

 private:
  std::size_t stride_;               // a multiple of every machine's lane count
  std::vector<double> coordinates_;  // all x, all y, all z, each padded with the first vertex
};

}  // namespace cwm::collision
