#include "collision/thread_pool/parker.h"

#include <gtest/gtest.h>
#include <sched.h>

#include <atomic>
#include <thread>

namespace cwm {
namespace {

TEST(Parker, DoesNotSleepWhoWasWokenBefore) {
  Parker parker;
  parker.PreparePark();
  parker.Unpark();
  parker.Park();  // would otherwise sleep forever
}

TEST(Parker, MayRunWhereItMightBefore) {
  cpu_set_t before, after;
  Parker parker;
  std::atomic<bool> lies{false};
  std::jthread thread([&] {
    ASSERT_EQ(sched_getaffinity(0, sizeof(before), &before), 0);
    for (int k = 0; k < 100; ++k) {
      parker.PreparePark();
      lies = true;
      parker.Park();
    }
    ASSERT_EQ(sched_getaffinity(0, sizeof(after), &after), 0);
  });
  for (int k = 0; k < 100; ++k) {
    while (!lies.exchange(false)) std::this_thread::yield();
    parker.Unpark();
  }
  thread.join();
  EXPECT_TRUE(CPU_EQUAL(&before, &after));
}

// A thread that may run on one core only is woken there.
TEST(Parker, StaysOnTheOnlyCoreThatItMayRunOn) {
  Parker parker;
  std::atomic<bool> lies{false}, stayed{true};
  std::jthread thread([&] {
    cpu_set_t one;
    CPU_ZERO(&one);
    const int core = sched_getcpu();
    CPU_SET(core, &one);
    ASSERT_EQ(sched_setaffinity(0, sizeof(one), &one), 0);
    for (int k = 0; k < 100; ++k) {
      parker.PreparePark();
      lies = true;
      parker.Park();
      if (sched_getcpu() != core) stayed = false;
    }
  });
  for (int k = 0; k < 100; ++k) {
    while (!lies.exchange(false)) std::this_thread::yield();
    parker.Unpark();
  }
  thread.join();
  EXPECT_TRUE(stayed);
}

}  // namespace
}  // namespace cwm
