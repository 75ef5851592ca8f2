// An order of points in which neighbours follow each other: what makes a block of points small
// however a batch lists them.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "collision/geometry/pose.h"

namespace cwm::collision {

// Along a Z-shaped curve (Morton 1966) through 16 x 16 x 16 cells over the points; within a cell as
// listed. Keeps its memory from one call to the next.
class PointOrder {
 public:
  // Indices into `points`, valid until the next call.
  std::span<const std::uint32_t> Of(std::span<const Vector3> points);

 private:
  static constexpr int kBitsPerAxis = 4;
  static constexpr std::size_t kCells = std::size_t{1} << (3 * kBitsPerAxis);

  std::vector<std::uint16_t> cells_;   // of each point
  std::vector<std::uint32_t> begins_;  // of each cell
  std::vector<std::uint32_t> indices_;
};

}  // namespace cwm::collision
