// What a long piece of work may use, and when it must end: handed through all stages of perception.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
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
  // How many of them may run just now, asked before each piece of work: a loop that is under way on
  // more gives threads back, and the next one starts with as many. May be empty: all. Cheap, and
  // safe on all threads at once.
  std::function<int()> threads_now = {};
  std::stop_token stop = {};
  // Called before each piece of work, by whatever thread does it, at most about a millisecond apart
  // on each thread: the place to count pieces. Cheap, and safe on all threads at once. May be
  // empty.
  std::function<void()> on_piece = {};

  // At least one, at most max_threads.
  int Threads() const {
    const int allowed = threads_now ? std::min(threads_now(), max_threads) : max_threads;
    return std::max(allowed, 1);
  }

  // Between two pieces. Throws Stopped once the stop was requested.
  void Poll() const {
    if (stop.stop_requested()) throw Stopped();
    if (on_piece) on_piece();
  }
};

// Work on one thread that nobody stops.
inline const Work kUnbounded;

// How many items make a piece of work, by what one takes: measured on two cores of 2.5 GHz.
constexpr std::size_t ItemsPerPiece(std::chrono::nanoseconds of_one) {
  // chosen: a loop answers a stop within a millisecond.
  constexpr std::chrono::microseconds kPiece(400);
  return static_cast<std::size_t>(std::max<std::chrono::nanoseconds::rep>(1, kPiece / of_one));
}

// Polls on every `steps`-th call: for loops whose single step is much shorter than a piece. One per
// loop and thread.
class PollEvery {
 public:
  PollEvery(const Work& work, std::size_t steps) : work_(work), steps_(steps) {}
  void operator()() {
    if (++taken_ < steps_) return;
    taken_ = 0;
    work_.Poll();
  }

 private:
  const Work& work_;
  std::size_t steps_;
  std::size_t taken_ = 0;
};

}  // namespace cwm::perception
