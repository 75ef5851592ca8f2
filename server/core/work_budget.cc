#include "server/core/work_budget.h"

#include <utility>

#include "server/core/error.h"

namespace cwm::server {

WorkBudget::WorkBudget(Clock::time_point deadline, std::stop_token stop)
    : deadline_(deadline), stop_(std::move(stop)) {}

bool WorkBudget::MustEndNow() {
  steps_ = 0;
  if (end_ != End::kNone) return true;
  ++check_count_;
  end_ = Check();
  return end_ != End::kNone;
}

WorkBudget::End WorkBudget::Check() const {
  if (stop_.stop_requested()) return End::kCancelled;
  const bool has_deadline = deadline_ != Clock::time_point::max();
  return has_deadline && Clock::now() >= deadline_ ? End::kOutOfTime : End::kNone;
}

absl::Status WorkBudget::status() const {
  switch (end_) {
    case End::kNone:
      break;
    case End::kCancelled:
      return MakeError(absl::StatusCode::kCancelled, "the call was cancelled",
                       {.reason = "CANCELLED"});
    case End::kOutOfTime:
      return MakeError(absl::StatusCode::kDeadlineExceeded,
                       "the deadline was reached before the request was read and done",
                       {.reason = "TIME_BUDGET_SPENT"});
  }
  return absl::OkStatus();
}

}  // namespace cwm::server
