// The surfaces that a moving sensor has seen and that were interpreted, modelled or not.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "absl/container/flat_hash_set.h"
#include "perception/live/frame_evidence.h"

namespace cwm::perception {

// A sparse grid of cells in the world. A point counts as known if it lies in the cell of a seen
// point or in one beside it: within one to two cells, which is more than the errors of a moving
// sensor's pose.
class SeenSurface {
 public:
  // chosen: poses of moving sensors err by some millimetres, and by 15 mm at 2 m.
  static constexpr double kCell_m = 0.03;
  // chosen: a thousand square metres of surface; beyond it nothing is added.
  static constexpr std::size_t kMaxCells = 4'000'000;

  bool IsKnown(const Eigen::Vector3d& p_W) const { return cells_.contains(KeyOf(CellOf(p_W))); }
  bool empty() const { return cells_.empty(); }

  // Adds the points of these blocks of a frame, but those of robots and their outlines.
  void Add(const FrameEvidence& frame, std::span<const std::int32_t> blocks);

 private:
  using Cell = Eigen::Matrix<std::int64_t, 3, 1>;
  static Cell CellOf(const Eigen::Vector3d& p_W) {
    return (p_W / kCell_m).array().floor().cast<std::int64_t>();
  }
  static std::uint64_t KeyOf(const Cell& cell);

  absl::flat_hash_set<std::uint64_t> cells_;  // of points, and those beside them
};

}  // namespace cwm::perception
