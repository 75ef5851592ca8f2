#include "collision/thread_pool/thread_pool.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <mutex>
#include <set>
#include <stdexcept>
#include <thread>
#include <vector>

namespace cwm {
namespace {

// How ranges are shared among threads and nested loops is tested with
// perception/cloud/parallel_for, a loop that can also be cancelled.

void RunLoop(std::size_t count, int threads, const ParallelLoop::Body& body) {
  ParallelLoop(
      count, 1, [&] { return threads; }, body)
      .Run();
}

void WorkFor(std::chrono::microseconds time) {
  const auto end = std::chrono::steady_clock::now() + time;
  while (std::chrono::steady_clock::now() < end) continue;
}

// Threads that wait first stay awake and then sleep. The work here takes about as long as they stay
// awake, at the end of a loop or between loops, so that they are woken at every step of falling
// asleep.
TEST(ParallelLoop, WakesWhoeverFellAsleep) {
  constexpr int kLoops = 3000;
  for (const int threads : {2, 4}) {
    std::atomic<int> calls{0};
    for (int k = 0; k < kLoops; ++k) {
      WorkFor(std::chrono::microseconds(k % 7 == 0 ? 295 + k % 11 : 0));
      RunLoop(3, threads, [&](std::size_t begin, std::size_t) {
        if (begin != 0) WorkFor(std::chrono::microseconds(k % 5 == 0 ? 295 + k % 13 : 1));
        RunLoop(2, threads, [&](std::size_t, std::size_t) { ++calls; });
      });
    }
    EXPECT_EQ(calls, 6 * kLoops);
  }
}

TEST(ParallelLoop, KeepsItsHelpersForTheNextOne) {
  std::mutex mutex;
  std::set<std::thread::id> seen;
  for (int k = 0; k < 200; ++k) {
    RunLoop(20, 3, [&](std::size_t, std::size_t) {
      const std::lock_guard lock(mutex);
      seen.insert(std::this_thread::get_id());
    });
  }
  EXPECT_LE(seen.size(), 3U);
}

TEST(ParallelLoop, RunsBesideThoseOfOtherThreads) {
  std::atomic<int> calls{0};
  {
    std::vector<std::jthread> threads;
    for (int t = 0; t < 4; ++t) {
      threads.emplace_back([&] {
        for (int k = 0; k < 100; ++k) RunLoop(10, 2, [&](std::size_t, std::size_t) { ++calls; });
      });
    }
  }
  EXPECT_EQ(calls, 4000);
}

TEST(ParallelLoop, RunsOnItsOwnThreadWhereItMayHaveNone) {
  std::set<std::thread::id> seen;
  for (const int threads : {-1, 0, 1}) {
    RunLoop(10, threads,
            [&](std::size_t, std::size_t) { seen.insert(std::this_thread::get_id()); });
  }
  EXPECT_EQ(seen, std::set<std::thread::id>{std::this_thread::get_id()});
}

TEST(ParallelLoop, HandsOnTheExceptionOfAHelper) {
  const std::thread::id caller = std::this_thread::get_id();
  std::atomic<bool> has_thrown{false};
  const auto body = [&](std::size_t, std::size_t) {
    if (std::this_thread::get_id() != caller) {
      has_thrown = true;
      throw std::runtime_error("a helper's");
    }
    while (!has_thrown) std::this_thread::yield();
  };
  EXPECT_THROW(RunLoop(2, 2, body), std::runtime_error);
  std::atomic<int> calls{0};
  RunLoop(10, 2, [&](std::size_t, std::size_t) { ++calls; });
  EXPECT_EQ(calls, 10) << "the helper lives on";
}

}  // namespace
}  // namespace cwm
