// Whole paths: edges one after the other, with one answer.
#pragma once

#include <cstddef>
#include <span>
#include <stop_token>

#include "absl/status/statusor.h"
#include "collision/motion/check_motions.h"
#include "collision/motion/waypoints.h"

namespace cwm::collision {

// Rows [first_row, first_row + row_count) of the waypoints: at least two.
struct Path {
  std::size_t first_row = 0;
  std::size_t row_count = 2;
};

// One entry a path. A path with a row outside of its limits is kOutOfLimits, and nothing more is
// looked at. Else its first edge in contact tells, and what lies behind it is not looked at; else
// the first undecided one, else the first that grazes. A free path has the least clearance of its
// edges; one that is free or grazes, the weakest trust of them.
//
// Engines, margins and `stop` as in CheckMotions.
absl::StatusOr<MotionColumns> CheckPaths(const WorldSnapshot& world, const QueryBody& body,
                                         const Waypoints& waypoints, std::span<const Path> paths,
                                         const QueryOptions& options, std::stop_token stop = {});

}  // namespace cwm::collision
