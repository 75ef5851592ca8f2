// The deadline at which the threads of a batch must stop so that its result is delivered in time.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <optional>

#include "collision/query/query.h"

namespace cwm::collision {

// The deadline minus the time that handing over the answers counted so far will take. Thread safe.
class TimeLimit {
 public:
  using Clock = std::chrono::steady_clock;

  explicit TimeLimit(const QueryOptions& options)
      : deadline_(options.deadline), handover_(options.handover_per_entry) {}

  void Count(std::size_t answers) {
    answers_.fetch_add(static_cast<std::int64_t>(answers), std::memory_order_relaxed);
  }

  bool IsReached() const {
    if (!deadline_.has_value()) return false;
    return Clock::now() + handover_ * answers_.load(std::memory_order_relaxed) >= *deadline_;
  }

 private:
  const std::optional<Clock::time_point> deadline_;
  const std::chrono::nanoseconds handover_;
  std::atomic<std::int64_t> answers_ = 0;
};

}  // namespace cwm::collision
