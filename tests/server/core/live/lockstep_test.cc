// Turns of frames in lockstep.
#include "server/core/live/lockstep.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <string>
#include <thread>
#include <vector>

namespace cwm::server {
namespace {

using ::testing::ElementsAre;

class LockstepTest : public ::testing::Test {
 protected:
  void Begin(const std::string& frame) {
    lockstep_.Begin([this, frame] { events_.push_back(frame + " begins"); });
  }
  void End(const std::string& frame) {
    lockstep_.End([this, frame] { events_.push_back(frame + " ends"); });
  }

  std::vector<std::string> events_;
  Lockstep lockstep_;
};

TEST_F(LockstepTest, FramesTakeTurnsInTheOrderInWhichTheyAsked) {
  Begin("a");
  Begin("b");
  Begin("c");
  EXPECT_THAT(events_, ElementsAre("a begins"));
  End("a");
  EXPECT_THAT(events_, ElementsAre("a begins", "a ends", "b begins"));
  End("b");
  End("c");
  Begin("d");
  EXPECT_THAT(events_, ElementsAre("a begins", "a ends", "b begins", "b ends", "c begins", "c ends",
                                   "d begins"));
}

TEST_F(LockstepTest, ATurnLastsUntilNothingRunsBeside) {
  Begin("a");
  Begin("b");
  Lockstep::Token first = lockstep_.RunBeside();
  Lockstep::Token copy = first;
  End("a");
  first.reset();
  EXPECT_THAT(events_, ElementsAre("a begins"));
  // A task may begin another one before it is done.
  Lockstep::Token second = lockstep_.RunBeside();
  copy.reset();
  EXPECT_THAT(events_, ElementsAre("a begins"));
  second.reset();
  EXPECT_THAT(events_, ElementsAre("a begins", "a ends", "b begins"));
}

TEST_F(LockstepTest, NoTurnBeginsWhileSomethingRunsBeside) {
  Lockstep::Token token = lockstep_.RunBeside();
  Begin("a");
  EXPECT_THAT(events_, ElementsAre());
  token.reset();
  EXPECT_THAT(events_, ElementsAre("a begins"));
}

TEST_F(LockstepTest, ThreadsHaveTheTurnOneAtATime) {
  constexpr int kThreads = 4, kTurns = 200;
  std::atomic<int> inside = 0, turns = 0;
  std::vector<std::thread> threads;
  for (int i = 0; i < kThreads; ++i) {
    threads.emplace_back([&] {
      for (int k = 0; k < kTurns; ++k) {
        std::atomic<bool> has_turn = false, has_ended = false;
        lockstep_.Begin([&] {
          EXPECT_EQ(++inside, 1);
          has_turn = true;
          has_turn.notify_one();
        });
        has_turn.wait(false);
        std::thread beside([token = lockstep_.RunBeside(), &inside] { EXPECT_EQ(inside, 1); });
        lockstep_.End([&] {
          EXPECT_EQ(--inside, 0);
          ++turns;
          has_ended = true;
          has_ended.notify_one();
        });
        beside.join();
        has_ended.wait(false);
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(turns, kThreads * kTurns);
}

}  // namespace
}  // namespace cwm::server
