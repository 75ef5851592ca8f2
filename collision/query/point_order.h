// An order in which neighbouring points follow each other, so that blocks of consecutive points are
// small whatever the order of the batch.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "collision/geometry/pose.h"

namespace cwm::collision {

// Z-order (Morton 1966) over 16 x 16 x 16 cells around the points; within a cell in the given
// order. Reuses its memory from call to call.
class PointOrder {
 public:
  // Indices into `points`, valid until the next call.
  std::span<const std::uint32_t> Sort(std::span<const Vector3> points);

 private:
  static constexpr int kBitsPerAxis = 4;
  static constexpr std::size_t kCells = std::size_t{1} << (3 * kBitsPerAxis);

  std::vector<std::uint16_t> cells_;   // cell of each point
  std::vector<std::uint32_t> begins_;  // first index of each cell
  std::vector<std::uint32_t> indices_;
};

}  // namespace cwm::collision
