// States that lie near each other put side by side: lanes that answer together then have the same
// to look at.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "collision/spheres/sphere_lanes.h"
#include "collision/spheres/sphere_program.h"

namespace cwm::collision {

// Cells of the joints' ranges, halved again and again across the joint that sweeps its spheres
// through the longest arc. Used by one thread.
class StateOrder {
 public:
  explicit StateOrder(const SphereProgram& program);

  // The places of `count` states, sorted by cell and within it by place; `values` as ToLanes leaves
  // them. The span holds until the next call.
  std::span<const std::uint32_t> Of(const float* values, std::size_t stride, std::size_t count);

 private:
  static constexpr int kHalvings = 10;  // of a thousand states, each has a cell of its own

  struct Axis {
    std::size_t input = 0;
    CellKeys cells;
  };
  std::vector<Axis> axes_;
  std::vector<std::uint32_t> keys_, order_, begin_;
};

}  // namespace cwm::collision
