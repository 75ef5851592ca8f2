#include "server/core/work_queue.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <atomic>
#include <future>
#include <stdexcept>
#include <thread>

namespace cwm::server {
namespace {

TEST(WorkQueue, DrainingFinishesWhatWasAccepted) {
  std::atomic<int> done{0};
  WorkQueue queue({.name = "test", .threads = 2, .capacity = 100});
  for (int i = 0; i < 100; ++i) ASSERT_TRUE(queue.TryPush([&] { ++done; }));
  queue.Drain();
  EXPECT_EQ(done, 100);
  EXPECT_EQ(queue.waiting(), 0u);
  EXPECT_FALSE(queue.TryPush([&] { ++done; }));
  queue.Drain();  // draining again is harmless
  EXPECT_EQ(done, 100);
}

TEST(WorkQueue, RefusesWhenFull) {
  std::promise<void> started;
  std::promise<void> release;
  WorkQueue queue({.name = "test", .threads = 1, .capacity = 2});
  ASSERT_TRUE(queue.TryPush([&] {
    started.set_value();
    release.get_future().wait();
  }));
  started.get_future().wait();
  EXPECT_TRUE(queue.TryPush([] {}));
  EXPECT_TRUE(queue.TryPush([] {}));
  EXPECT_FALSE(queue.TryPush([] {}));
  EXPECT_EQ(queue.waiting(), 2u);
  release.set_value();
  queue.Drain();
}

TEST(WorkQueue, LanesHaveTheirOwnPlacesAndAreServedInTurn) {
  std::promise<void> started;
  std::promise<void> release;
  std::string order;
  WorkQueue queue({.name = "test", .threads = 1, .capacity = 3, .awaited_capacity = 2});
  ASSERT_TRUE(queue.TryPush([&] {
    started.set_value();
    release.get_future().wait();
  }));
  started.get_future().wait();
  const auto awaited = WorkQueue::Lane::kAwaited;
  for (int i = 0; i < 2; ++i) EXPECT_TRUE(queue.TryPush([&] { order += 'a'; }, awaited));
  EXPECT_FALSE(queue.TryPush([&] { order += 'a'; }, awaited));
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(queue.TryPush([&] { order += 'n'; }));
  EXPECT_FALSE(queue.TryPush([&] { order += 'n'; }));
  EXPECT_EQ(queue.waiting(), 5u);
  release.set_value();
  queue.Drain();
  EXPECT_EQ(order, "nanan");
}

TEST(WorkQueue, TellsHowLongItHasBeenIdle) {
  std::promise<void> started;
  std::promise<void> release;
  WorkQueue queue({.name = "test", .threads = 1, .capacity = 2});
  EXPECT_EQ(queue.IdleFor(), Clock::duration::max());
  ASSERT_TRUE(queue.TryPush([&] {
    started.set_value();
    release.get_future().wait();
  }));
  started.get_future().wait();
  EXPECT_EQ(queue.IdleFor(), Clock::duration::zero());  // a task is running
  const Clock::time_point released = Clock::now();
  release.set_value();
  queue.Drain();
  EXPECT_LE(queue.IdleFor(), Clock::now() - released);
  const Clock::duration first = queue.IdleFor();
  std::this_thread::sleep_for(std::chrono::milliseconds(1));
  EXPECT_GE(queue.IdleFor(), first + std::chrono::milliseconds(1));
}

TEST(WorkQueue, SurvivesATaskThatThrows) {
  WorkQueue queue({.name = "test", .threads = 1, .capacity = 4});
  std::promise<void> after;
  ASSERT_TRUE(queue.TryPush([] { throw std::runtime_error("one bad task"); }));
  ASSERT_TRUE(queue.TryPush([&] { after.set_value(); }));
  after.get_future().wait();
  EXPECT_EQ(queue.failed(), 1);
}

TEST(WorkQueue, RunsATaskInTheCallersThread) {
  WorkQueue queue({.name = "test", .threads = 1, .capacity = 2});
  std::thread::id where;
  Clock::duration idle_within = Clock::duration::max();
  ASSERT_TRUE(queue.TryRunInline([&] {
    where = std::this_thread::get_id();
    idle_within = queue.IdleFor();
  }));
  EXPECT_EQ(where, std::this_thread::get_id());
  EXPECT_EQ(idle_within, Clock::duration::zero());
  EXPECT_LT(queue.IdleFor(), Clock::duration::max());
  EXPECT_TRUE(queue.TryRunInline([] { throw std::runtime_error("one bad task"); }));
  EXPECT_EQ(queue.failed(), 1);
}

TEST(WorkQueue, TakesOneCallerAtATime) {
  WorkQueue queue({.name = "test", .threads = 2, .capacity = 2});
  bool second = true;
  ASSERT_TRUE(queue.TryRunInline([&] { second = queue.TryRunInline([] {}); }));
  EXPECT_FALSE(second);
  EXPECT_TRUE(queue.TryRunInline([] {}));
}

TEST(WorkQueue, TakesNoCallerWhileItsThreadsAreAtWork) {
  std::promise<void> started;
  std::promise<void> release;
  WorkQueue queue({.name = "test", .threads = 1, .capacity = 2});
  ASSERT_TRUE(queue.TryPush([&] {
    started.set_value();
    release.get_future().wait();
  }));
  started.get_future().wait();
  EXPECT_FALSE(queue.TryRunInline([] {}));
  release.set_value();
  queue.Drain();
  EXPECT_FALSE(queue.TryRunInline([] {}));
}

TEST(WorkQueue, DrainingWaitsForTheCallerThatRunsATask) {
  WorkQueue queue({.name = "test", .threads = 1, .capacity = 2});
  std::promise<void> started;
  std::atomic<bool> is_done = false;
  std::thread caller([&] {
    queue.TryRunInline([&] {
      started.set_value();
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
      is_done = true;
    });
  });
  started.get_future().wait();
  queue.Drain();
  EXPECT_TRUE(is_done);
  caller.join();
}

TEST(WorkQueue, LowersThePriorityOfItsOwnThreadsAlone) {
  const int before = getpriority(PRIO_PROCESS, static_cast<id_t>(syscall(SYS_gettid)));
  std::promise<int> inside;
  WorkQueue queue({.name = "low priority queue", .threads = 1, .capacity = 1, .nice = 10});
  ASSERT_TRUE(queue.TryPush([&] {
    inside.set_value(getpriority(PRIO_PROCESS, static_cast<id_t>(syscall(SYS_gettid))));
  }));
  EXPECT_EQ(inside.get_future().get(), 10);
  EXPECT_EQ(getpriority(PRIO_PROCESS, static_cast<id_t>(syscall(SYS_gettid))), before);
}

}  // namespace
}  // namespace cwm::server
