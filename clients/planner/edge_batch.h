// Straight motions, discretised into states that are checked in one batch.
#pragma once

#include <cstddef>
#include <vector>

#include "absl/status/statusor.h"
#include "clients/planner/joint_space.h"
#include "clients/planner/state_checker.h"

namespace cwm::planner {

// chosen: the largest distance in the joint space between the checked states of a motion, at which
// every motion of a result is checked: no joint moves further between two states.
inline constexpr double kFineStep = 0.01;
// chosen: the step of growing trees. A motion that is free at this step is rarely in collision, and
// if so, the fine step detects it.
inline constexpr double kCoarseStep = 0.15;

// Collects motions and checks all of them at once.
class EdgeBatch {
 public:
  // Both must outlive the batch.
  EdgeBatch(const JointSpace& space, StateChecker& checker) : space_(space), checker_(checker) {}

  // Adds the motion without its start, which is known to be free: its end and evenly spaced states
  // in between, at most `step` apart, with each step split into `parts`. Returns its index.
  std::size_t Add(std::span<const double> from, std::span<const double> to, double step,
                  std::size_t parts = 1);
  // Adds a single state.
  std::size_t Add(std::span<const double> row);
  std::size_t size() const { return begins_.size(); }

  // Checks the batch; motions added afterwards begin a new batch.
  absl::Status CheckAll();

  // For the last checked batch: the share of the motion up to the last free state before the first
  // that is not free. 1 if all of it is free, 0 if nothing is.
  double FreeFraction(std::size_t edge) const { return free_fractions_[edge]; }
  bool IsFree(std::size_t edge) const { return free_fractions_[edge] == 1; }

 private:
  const JointSpace& space_;
  StateChecker& checker_;
  std::vector<double> rows_;
  std::vector<std::size_t> begins_;  // indices into rows_
  std::vector<double> free_fractions_;
};

}  // namespace cwm::planner
