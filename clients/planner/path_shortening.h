// Shortens paths by shortcuts that are checked in batches.
#pragma once

#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"
#include "clients/planner/edge_batch.h"
#include "clients/planner/joint_space.h"
#include "clients/planner/state_checker.h"

namespace cwm::planner {

struct ShorteningOptions {
  int rounds = 6;      // at most; two rounds without a shortcut end it
  int shortcuts = 24;  // tried per round
  std::uint32_t seed = 1;
};

double LengthOf(const JointSpace& space, const std::vector<Row>& path);

// A path with the same ends that is not longer. Each round proposes straight motions between places
// on the path and checks all of them at the coarse step; of the free ones, those that save most
// without overlapping are checked at the fine step and taken. The result is checked at the fine
// step motion by motion, as the given path must have been.
absl::StatusOr<std::vector<Row>> Shorten(const JointSpace& space, StateChecker& checker,
                                         std::vector<Row> path, const ShorteningOptions& options);

}  // namespace cwm::planner
