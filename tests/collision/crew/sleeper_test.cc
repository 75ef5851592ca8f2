#include "collision/crew/sleeper.h"

#include <gtest/gtest.h>
#include <sched.h>

#include <atomic>
#include <thread>

namespace cwm {
namespace {

TEST(Sleeper, DoesNotSleepWhoWasWokenBefore) {
  Sleeper sleeper;
  sleeper.LieDown();
  sleeper.Wake();
  sleeper.Sleep();  // would otherwise sleep forever
}

TEST(Sleeper, MayRunWhereItMightBefore) {
  cpu_set_t before, after;
  Sleeper sleeper;
  std::atomic<bool> lies{false};
  std::jthread thread([&] {
    ASSERT_EQ(sched_getaffinity(0, sizeof(before), &before), 0);
    for (int k = 0; k < 100; ++k) {
      sleeper.LieDown();
      lies = true;
      sleeper.Sleep();
    }
    ASSERT_EQ(sched_getaffinity(0, sizeof(after), &after), 0);
  });
  for (int k = 0; k < 100; ++k) {
    while (!lies.exchange(false)) std::this_thread::yield();
    sleeper.Wake();
  }
  thread.join();
  EXPECT_TRUE(CPU_EQUAL(&before, &after));
}

// A thread that may run on one core only is woken there.
TEST(Sleeper, StaysOnTheOnlyCoreThatItMayRunOn) {
  Sleeper sleeper;
  std::atomic<bool> lies{false}, stayed{true};
  std::jthread thread([&] {
    cpu_set_t one;
    CPU_ZERO(&one);
    const int core = sched_getcpu();
    CPU_SET(core, &one);
    ASSERT_EQ(sched_setaffinity(0, sizeof(one), &one), 0);
    for (int k = 0; k < 100; ++k) {
      sleeper.LieDown();
      lies = true;
      sleeper.Sleep();
      if (sched_getcpu() != core) stayed = false;
    }
  });
  for (int k = 0; k < 100; ++k) {
    while (!lies.exchange(false)) std::this_thread::yield();
    sleeper.Wake();
  }
  thread.join();
  EXPECT_TRUE(stayed);
}

}  // namespace
}  // namespace cwm
