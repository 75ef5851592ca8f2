// The surfaces that a moving sensor has seen and that were interpreted, but are not modelled.
#pragma once

#include <cstdint>
#include <span>

#include "absl/container/flat_hash_set.h"
#include "perception/live/expected_gates.h"
#include "perception/live/frame_evidence.h"
#include "perception/live/world_cell.h"

namespace cwm::perception {

// A sparse grid of cells in the world. A point counts as known if it lies in the cell of a seen
// point or in one beside it: within one to two cells, which is more than the errors of a moving
// sensor's pose.
class SeenSurface {
 public:
  // chosen: a thousand square metres of surface; beyond it nothing is added.
  static constexpr std::size_t kMaxCells = 4'000'000;

  bool IsKnown(const Vector3& p_W) const { return cells_.contains(KeyOf(CellOf(p_W))); }
  bool empty() const { return cells_.empty(); }

  // Adds the points of these blocks of a frame that the gates, of the bodies that are known now, do
  // not hold; but none of robots and their outlines.
  void Add(const FrameEvidence& frame, std::span<const std::int32_t> blocks,
           const ExpectedGates& gates);

 private:
  absl::flat_hash_set<std::uint64_t> cells_;  // of points, and those beside them
};

}  // namespace cwm::perception
