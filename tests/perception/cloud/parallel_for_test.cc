#include "perception/cloud/parallel_for.h"

#include <gtest/gtest.h>

#include <atomic>
#include <mutex>
#include <set>
#include <stdexcept>
#include <thread>
#include <vector>

namespace cwm::perception {
namespace {

TEST(ParallelFor, VisitsEachIndexOnceOnAnyNumberOfThreads) {
  for (const int threads : {0, 1, 2, 5}) {
    for (const std::size_t range : {std::size_t{0}, std::size_t{1}, std::size_t{7}}) {
      std::vector<std::atomic<int>> visits(100);
      ParallelFor(visits.size(), range, {.max_threads = threads},
                  [&](std::size_t begin, std::size_t end) {
                    for (std::size_t i = begin; i < end; ++i) ++visits[i];
                  });
      for (const auto& count : visits) EXPECT_EQ(count, 1);
    }
  }
}

TEST(ParallelFor, DoesNothingForNothing) {
  ParallelFor(0, 1, {.max_threads = 2}, [](std::size_t, std::size_t) { FAIL(); });
}

TEST(ParallelFor, GivesAThreadBackBeforeItsNextRange) {
  constexpr int kRanges = 1000;
  constexpr int kUntilToldToGo = 10;
  const std::thread::id caller = std::this_thread::get_id();
  std::atomic<int> allowed{2}, by_helper{0}, by_caller{0};
  const Work work{.max_threads = 2, .threads_now = [&] { return allowed.load(); }};
  ParallelFor(kRanges, 1, work, [&](std::size_t, std::size_t) {
    if (std::this_thread::get_id() != caller) {
      if (++by_helper == kUntilToldToGo) allowed = 1;
      return;
    }
    ++by_caller;
    while (allowed == 2) std::this_thread::yield();  // leaves the ranges to the helper
  });
  EXPECT_EQ(by_helper, kUntilToldToGo);
  EXPECT_EQ(by_caller, kRanges - kUntilToldToGo);
}

TEST(ParallelFor, StartsNoMoreThreadsThanItMayUseNow) {
  std::mutex mutex;
  std::set<std::thread::id> seen;
  const Work work{.max_threads = 8, .threads_now = [] { return 0; }};  // clamped to one
  ParallelFor(100, 1, work, [&](std::size_t, std::size_t) {
    const std::lock_guard lock(mutex);
    seen.insert(std::this_thread::get_id());
  });
  EXPECT_EQ(seen, std::set<std::thread::id>{std::this_thread::get_id()});
}

TEST(ParallelFor, HandsOnTheFirstExceptionAndEndsEarly) {
  std::atomic<int> visited{0};
  EXPECT_THROW(ParallelFor(1'000'000, 1, {.max_threads = 2},
                           [&](std::size_t begin, std::size_t) {
                             ++visited;
                             if (begin == 10) throw std::runtime_error("bad range");
                           }),
               std::runtime_error);
  EXPECT_LT(visited, 1'000'000);
}

TEST(ParallelFor, EndsBeforeTheNextPieceOnceItIsToldToStop) {
  std::stop_source stop;
  int visited = 0;
  EXPECT_THROW(ParallelFor(100, 1, {.max_threads = 1, .stop = stop.get_token()},
                           [&](std::size_t begin, std::size_t) {
                             ++visited;
                             if (begin == 4) stop.request_stop();
                           }),
               Stopped);
  EXPECT_EQ(visited, 5);
}

TEST(ParallelFor, RunsOnNoMoreThreadsThanTheLoopAroundWasGiven) {
  std::atomic<int> calls{0}, running{0}, max_running{0};
  ParallelFor(8, 1, {.max_threads = 2}, [&](std::size_t, std::size_t) {
    ParallelFor(100, 1, {.max_threads = 4}, [&](std::size_t, std::size_t) {
      const int now = ++running;
      for (int seen = max_running; now > seen && !max_running.compare_exchange_weak(seen, now);)
        continue;
      ++calls;
      --running;
    });
  });
  EXPECT_EQ(calls, 800);
  EXPECT_LE(max_running, 2);
}

// The number of threads that run a loop of two ranges that wait for each other; never returns on
// one thread.
int ThreadsThatMeet(const Work& work) {
  std::mutex mutex;
  std::set<std::thread::id> seen;
  std::atomic<int> arrived{0};
  ParallelFor(2, 1, work, [&](std::size_t, std::size_t) {
    {
      const std::lock_guard lock(mutex);
      seen.insert(std::this_thread::get_id());
    }
    ++arrived;
    while (arrived < 2) std::this_thread::yield();
  });
  return static_cast<int>(seen.size());
}

TEST(ParallelFor, LeavesItsThreadsToTheLoopWithinWhereThereIsOneRange) {
  const Work work{.max_threads = 2};
  int threads = 0;
  ParallelFor(3, 3, work, [&](std::size_t, std::size_t) { threads = ThreadsThatMeet(work); });
  EXPECT_EQ(threads, 2);
}

// Repeats a loop until two threads have taken part in it; never returns if there is only one
// thread.
void LoopUntilTwoThreadsRan(const Work& work) {
  std::mutex mutex;
  std::set<std::thread::id> seen;
  for (bool both = false; !both;) {
    ParallelFor(100, 1, work, [&](std::size_t, std::size_t) {
      const std::lock_guard lock(mutex);
      seen.insert(std::this_thread::get_id());
      both = seen.size() == 2;
    });
  }
}

TEST(ParallelFor, TakesTheThreadThatTheLoopAroundHasNoMoreRangesFor) {
  const Work work{.max_threads = 2};
  bool taken = false;
  ParallelFor(2, 1, work, [&](std::size_t begin, std::size_t) {
    if (begin == 0) return;  // this range ends at once and frees its thread
    LoopUntilTwoThreadsRan(work);
    taken = true;
  });
  EXPECT_TRUE(taken);
}

TEST(ParallelFor, TakesTheThreadOfALoopFartherOutOnceThatHasNoMoreRanges) {
  const Work work{.max_threads = 2};
  std::atomic<bool> is_inside{false};
  bool taken = false;
  ParallelFor(2, 1, work, [&](std::size_t begin, std::size_t) {
    if (begin == 0) {  // keeps its thread from the loop in the middle
      while (!is_inside) std::this_thread::yield();
      return;
    }
    ParallelFor(2, 1, work, [&](std::size_t middle, std::size_t) {
      is_inside = true;
      if (middle == 1) return;
      LoopUntilTwoThreadsRan(work);
      taken = true;
    });
  });
  EXPECT_TRUE(taken);
}

TEST(ParallelFor, GivesThreadsBackToTheLoopAroundAfterAnException) {
  const Work work{.max_threads = 2};
  for (int k = 0; k < 50; ++k) {
    ParallelFor(2, 1, work, [&](std::size_t, std::size_t) {
      EXPECT_THROW(ParallelFor(10, 1, work,
                               [](std::size_t begin, std::size_t) {
                                 if (begin == 3) throw std::runtime_error("bad range");
                               }),
                   std::runtime_error);
    });
  }
  EXPECT_EQ(ThreadsThatMeet(work), 2);
}

}  // namespace
}  // namespace cwm::perception
