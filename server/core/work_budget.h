// The remaining time of a request, checked while it is read and while it is worked on.
#pragma once

#include <cstddef>
#include <cstdint>
#include <stop_token>

#include "absl/status/status.h"
#include "collision/geometry/work_counter.h"
#include "server/core/limits.h"

namespace cwm::server {

// Used by one thread. Functions that take a pointer to it have no time limit if it is nullptr.
class WorkBudget : public WorkCounter {
 public:
  enum class End { kNone, kCancelled, kOutOfTime };

  WorkBudget() = default;  // without a limit
  // Clock::time_point::max(): no deadline.
  WorkBudget(Clock::time_point deadline, std::stop_token stop);

  // Checks deadline and stop once per about a millisecond of steps.
  bool MustEndAfter(std::size_t steps) final {
    steps_ += steps;
    if (end_ != End::kNone || steps_ < kStepsBetweenChecks) return end_ != End::kNone;
    return MustEndNow();
  }
  bool MustEndNow() final;

  End end() const { return end_; }
  // CANCELLED, or DEADLINE_EXCEEDED TIME_BUDGET_SPENT; OK if the budget has not ended.
  absl::Status status() const;
  // Number of checks made.
  std::int64_t check_count() const { return check_count_; }

 protected:
  // The result of one check of stop and deadline.
  virtual End Check() const;

 private:
  static constexpr std::size_t kStepsBetweenChecks = std::size_t{1} << 15;

  Clock::time_point deadline_ = Clock::time_point::max();
  std::stop_token stop_;
  std::size_t steps_ = kStepsBetweenChecks;  // so that the first step checks
  std::int64_t check_count_ = 0;
  End end_ = End::kNone;
};

}  // namespace cwm::server
