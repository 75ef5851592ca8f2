// Straight motions, as states that are asked in one batch.
#pragma once

#include <cstddef>
#include <vector>

#include "absl/status/statusor.h"
#include "clients/planner/joint_space.h"
#include "clients/planner/state_checker.h"

namespace cwm::planner {

// How far apart the states of a motion are, at most, in the distance of the space.
// Every motion of an answer has been asked at this one: no joint moves by more between two states.
inline constexpr double kFineStep = 0.01;
// What trees grow by: a motion that is free at such steps is rarely not (README.md), and then the
// fine step tells.
inline constexpr double kCoarseStep = 0.15;

// Collects motions and asks about all of them at once.
class EdgeBatch {
 public:
  // Both must outlive the batch.
  EdgeBatch(const JointSpace& space, StateChecker& checker) : space_(space), checker_(checker) {}

  // The motion without its beginning, which is known to be free: its end and states between,
  // evenly, so many that none is more than a step from the next, and each step in so many parts.
  // Returns its index.
  std::size_t Add(std::span<const double> from, std::span<const double> to, double step,
                  std::size_t parts = 1);
  // A single state.
  std::size_t Add(std::span<const double> row);
  std::size_t size() const { return begins_.size(); }

  // Asks; whatever was added before belongs to a batch that is over.
  absl::Status Ask();

  // Of the last batch asked. The share of the motion up to its last free state before the first
  // that is not: 1 where all of it is free, 0 where nothing is.
  double FreeShare(std::size_t edge) const { return shares_[edge]; }
  bool IsFree(std::size_t edge) const { return shares_[edge] == 1; }

 private:
  const JointSpace& space_;
  StateChecker& checker_;
  std::vector<double> rows_;
  std::vector<std::size_t> begins_;  // in rows
  std::vector<double> shares_;
};

}  // namespace cwm::planner
