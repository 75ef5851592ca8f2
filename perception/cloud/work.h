// The limits of a long computation, its threads and its stop request, handed through all stages of
// perception.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <exception>
#include <functional>
#include <stop_token>

namespace cwm::perception {

// Ends work that was asked to stop, from any depth. Only Work::Poll throws it, and the functions
// where the work began (InterpretScene, SegmentScene) catch it and return CANCELLED, so no partial
// result can be mistaken for a complete one.
class Stopped : public std::exception {
 public:
  const char* what() const noexcept override { return "stopped"; }
};

struct Work {
  int max_threads = 1;
  // The number of threads that may run now, read before each piece of work: a running loop with
  // more threads gives threads back, and the next loop starts with as many. If empty, all threads
  // may run. Must be cheap and thread-safe.
  std::function<int()> threads_now = {};
  std::stop_token stop = {};
  // Called before each piece of work by the thread that does it, at most about a millisecond apart
  // on each thread; it may count pieces. Must be cheap and thread-safe. May be empty.
  std::function<void()> on_chunk = {};

  // The number of threads to use, at least one and at most max_threads.
  int Threads() const {
    const int allowed = threads_now ? std::min(threads_now(), max_threads) : max_threads;
    return std::max(allowed, 1);
  }

  // Called between two pieces of work. Throws Stopped once the stop was requested.
  void Poll() const {
    if (stop.stop_requested()) throw Stopped();
    if (on_chunk) on_chunk();
  }
};

// Work on one thread that is never stopped.
inline const Work kSerialWork;

// The number of items in one piece of work, from the time of one item, measured on two cores of 2.5
// GHz.
constexpr std::size_t ItemsPerChunk(std::chrono::nanoseconds of_one) {
  // chosen: a loop answers a stop within a millisecond.
  constexpr std::chrono::microseconds kPiece(400);
  return static_cast<std::size_t>(std::max<std::chrono::nanoseconds::rep>(1, kPiece / of_one));
}

// Polls on every `steps`-th call, for loops whose single step is much shorter than a piece. Each
// loop and thread needs its own.
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
