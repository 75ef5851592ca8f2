// Shorter paths, by short cuts that are asked many at once.
#pragma once

#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"
#include "clients/planner/edge_batch.h"
#include "clients/planner/joint_space.h"
#include "clients/planner/state_checker.h"

namespace cwm::planner {

struct ShorteningOptions {
  int rounds = 6;  // at most; two without a short cut end it
  int cuts = 24;   // tried a round
  std::uint32_t seed = 1;
};

double LengthOf(const JointSpace& space, const std::vector<Row>& path);

// A path from the same beginning to the same end that is no longer. Each round proposes straight
// motions between places on the path and asks about all of them at the coarse step; of those that
// are free the ones that save most, side by side, are asked at the fine step and taken. The answer
// has been asked at the fine step motion by motion, as the path that was given has.
absl::StatusOr<std::vector<Row>> Shorten(const JointSpace& space, StateChecker& checker,
                                         std::vector<Row> path, const ShorteningOptions& options);

}  // namespace cwm::planner
