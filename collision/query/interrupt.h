// When a batch must end early: because the caller went away, or because its time is up.
#pragma once

#include <chrono>
#include <optional>
#include <stop_token>
#include <utility>

namespace cwm::collision {

// Used by one thread.
class Interrupt {
 public:
  enum class Reason { kNone, kStopped, kTimeUp };

  Interrupt(std::stop_token stop, std::optional<std::chrono::steady_clock::time_point> give_up_at)
      : stop_(std::move(stop)), give_up_at_(give_up_at) {}

  // Counts work and looks around now and then; true when the batch must end. A unit is about a
  // microsecond or less; a heavy step states its weight.
  bool After(int units) {
    work_ += units;
    if (work_ < kUnitsBetweenLooks) return reason_ != Reason::kNone;
    return Look();
  }

  bool Look() {
    work_ = 0;
    if (reason_ != Reason::kNone) return true;
    if (stop_.stop_requested()) reason_ = Reason::kStopped;
    if (give_up_at_.has_value() && std::chrono::steady_clock::now() >= *give_up_at_) {
      reason_ = Reason::kTimeUp;
    }
    return reason_ != Reason::kNone;
  }

  Reason reason() const { return reason_; }

 private:
  // A look costs 30 ns; 64 units keep it below a hundredth and the reaction far below 10 ms.
  static constexpr int kUnitsBetweenLooks = 64;

  std::stop_token stop_;
  std::optional<std::chrono::steady_clock::time_point> give_up_at_;
  int work_ = kUnitsBetweenLooks;  // the first step looks
  Reason reason_ = Reason::kNone;
};

}  // namespace cwm::collision
