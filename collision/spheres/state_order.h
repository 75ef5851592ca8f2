// Orders states so that similar states are next to each other: the lanes of one vector then need
// the same tests.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "collision/spheres/sphere_lanes.h"
#include "collision/spheres/sphere_program.h"

namespace cwm::collision {

// Divides the ranges of the joints into cells, by repeatedly halving the joint that moves its
// spheres along the longest arc. Used by one thread.
class StateOrder {
 public:
  explicit StateOrder(const SphereProgram& program);

  // The indices of `count` states, sorted by cell, and within a cell by index; `values` as from
  // LoadStates. The span is valid until the next call.
  std::span<const std::uint32_t> Sort(const float* values, std::size_t stride, std::size_t count);

 private:
  static constexpr int kHalvings = 10;  // chosen: a thousand states then have a cell each

  struct Axis {
    std::size_t input = 0;
    CellKeys cells;
  };
  std::vector<Axis> axes_;
  std::vector<std::uint32_t> keys_, order_, begin_;
};

}  // namespace cwm::collision
