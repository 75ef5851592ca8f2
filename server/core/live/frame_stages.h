// The time that a frame took, by stage.
#pragma once

#include <chrono>
#include <utility>
#include <vector>

#include "server/core/live/live_frame.h"

namespace cwm::server {

inline double Milliseconds(Clock::duration time) {
  return std::chrono::duration<double, std::milli>(time).count();
}

// The stages of a frame, each from the end of the one before.
class FrameStages {
 public:
  explicit FrameStages(const LiveFrame& frame) : last_(frame.received) {
    End("receive", frame.begun);
    End("decode", frame.decoded);
  }
  void End(const char* stage, Clock::time_point now = Clock::now()) {
    times_.push_back({.stage = stage, .elapsed_ms = Milliseconds(now - last_)});
    last_ = now;
  }
  std::vector<perception::StageTime> Take() { return std::move(times_); }
  Clock::time_point last() const { return last_; }

 private:
  std::vector<perception::StageTime> times_;
  Clock::time_point last_;
};

}  // namespace cwm::server
