// Checks whole paths: several edges with one answer.
#pragma once

#include <cstddef>
#include <span>
#include <stop_token>

#include "absl/status/statusor.h"
#include "collision/motion/check_motions.h"
#include "collision/motion/waypoints.h"

namespace cwm::collision {

// Rows [first_row, first_row + row_count) of the waypoints; row_count is at least two.
struct Path {
  std::size_t first_row = 0;
  std::size_t row_count = 2;
};

// Columns with one entry per path. A path with a row out of limits is kOutOfLimits and is not
// checked further. Otherwise the answer is that of the first edge in contact, and the edges behind
// it are not checked; else that of the first undecided edge; else that of the first edge that
// grazes. A free path has the smallest clearance of its edges; a path that is free or grazes has
// the weakest accuracy of its edges.
//
// Engines, margins and `stop` are as in CheckMotions.
absl::StatusOr<MotionColumns> CheckPaths(const WorldSnapshot& world, const QueryBody& body,
                                         const Waypoints& waypoints, std::span<const Path> paths,
                                         const QueryOptions& options, std::stop_token stop = {});

}  // namespace cwm::collision
