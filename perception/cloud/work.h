// What a long piece of work may use, and when it must end: handed through all stages of perception.
#pragma once

#include <exception>
#include <functional>
#include <stop_token>

namespace cwm::perception {

// Ends work that was asked to stop, from wherever it is. Thrown by Work::Poll alone and caught
// where the work began (InterpretScene, SegmentScene), which return CANCELLED: nothing half-made
// can be taken for a result.
class Stopped : public std::exception {
 public:
  const char* what() const noexcept override { return "stopped"; }
};

struct Work {
  int max_threads = 1;
  std::stop_token stop = {};
  // Called before each piece of work, by whatever thread does it, at most about a millisecond apart
  // on each thread: the place to count pieces. Cheap, and safe on all threads at once. May be
  // empty.
  std::function<void()> on_piece = {};

  // Between two pieces. Throws Stopped once the stop was requested.
  void Poll() const {
    if (stop.stop_requested()) throw Stopped();
    if (on_piece) on_piece();
  }
};

// Polls on every `steps`-th call: for loops whose single step is much shorter than a piece. One per
// loop and thread.
class PollEvery {
 public:
  PollEvery(const Work& work, int steps) : work_(work), steps_(steps) {}
  void operator()() {
    if (++taken_ < steps_) return;
    taken_ = 0;
    work_.Poll();
  }

 private:
  const Work& work_;
  int steps_;
  int taken_ = 0;
};

}  // namespace cwm::perception
