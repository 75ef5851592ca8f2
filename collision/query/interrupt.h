// When a batch must end early: because the caller went away, or because its time is up.
#pragma once

#include <algorithm>
#include <cstddef>
#include <stop_token>
#include <utility>

#include "collision/kernels/work_counter.h"
#include "collision/query/time_limit.h"

namespace cwm::collision {

// Used by one thread.
class Interrupt final : public WorkCounter {
 public:
  enum class Reason { kNone, kStopped, kTimeUp };

  Interrupt() = default;  // never
  // `limit` is that of the batch, which outlives this.
  Interrupt(std::stop_token stop, const TimeLimit& limit)
      : stop_(std::move(stop)), limit_(&limit) {}

  // Counts work and looks around now and then; true when the batch must end. A unit is about a
  // microsecond or less; a heavy step states its weight.
  bool After(int units) {
    work_ += units;
    if (work_ < kUnitsBetweenLooks) return reason_ != Reason::kNone;
    return Look();
  }

  // What a kernel does within a pair, in steps of some tens of nanoseconds.
  bool MustEndAfter(std::size_t steps) override {
    steps_ += steps;
    if (steps_ < kStepsOfUnit) return reason_ != Reason::kNone;
    const std::size_t units = std::min<std::size_t>(steps_ / kStepsOfUnit, kUnitsBetweenLooks);
    steps_ = 0;
    return After(static_cast<int>(units));
  }

  bool MustEndNow() override { return Look(); }

  bool Look() {
    work_ = 0;
    if (reason_ != Reason::kNone) return true;
    if (stop_.stop_requested()) reason_ = Reason::kStopped;
    if (limit_ != nullptr && limit_->IsReached()) reason_ = Reason::kTimeUp;
    return reason_ != Reason::kNone;
  }

  Reason reason() const { return reason_; }

 private:
  // A look costs 30 ns; 64 units keep it below a hundredth and the reaction far below 10 ms.
  static constexpr int kUnitsBetweenLooks = 64;
  static constexpr std::size_t kStepsOfUnit = 32;

  std::stop_token stop_;
  const TimeLimit* limit_ = nullptr;
  int work_ = kUnitsBetweenLooks;  // the first step looks
  std::size_t steps_ = 0;          // less than a unit
  Reason reason_ = Reason::kNone;
};

}  // namespace cwm::collision
