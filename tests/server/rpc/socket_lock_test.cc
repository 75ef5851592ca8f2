#include "server/rpc/socket_lock.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <optional>
#include <thread>
#include <vector>

#include "tests/support/process.h"

namespace cwm::server {
namespace {

using ::testing::HasSubstr;

TEST(SocketLock, LeavesNoFileBehindAndCanBeTakenAgain) {
  const testing::ScratchDirectory scratch;
  const std::string path = scratch / "cwm.sock";
  for (int i = 0; i < 2; ++i) {
    const auto lock = SocketLock::Take(path);
    ASSERT_TRUE(lock.ok()) << lock.status();
    EXPECT_EQ(access((path + ".lock").c_str(), F_OK), 0);
  }
  EXPECT_NE(access((path + ".lock").c_str(), F_OK), 0);
}

// Each makes, locks, removes and makes the file again: at no time do two hold one.
TEST(SocketLock, IsHeldByOneAtATimeThoughItsFileComesAndGoes) {
  constexpr int kThreads = 8;
  constexpr int kRounds = 100;
  const testing::ScratchDirectory scratch;
  const std::string path = scratch / "cwm.sock";
  std::atomic<int> holders = 0;
  std::atomic<int> taken = 0;
  std::atomic<int> most = 0;
  {
    std::vector<std::jthread> threads;
    for (int i = 0; i < kThreads; ++i) {
      threads.emplace_back([&] {
        for (int round = 0; round < kRounds; ++round) {
          const auto lock = SocketLock::Take(path);
          if (!lock.ok()) continue;  // out of patience on a busy machine
          ++taken;
          const int now = ++holders;
          if (now > most) most = now;
          std::this_thread::yield();
          --holders;
        }
      });
    }
  }
  EXPECT_EQ(most, 1);
  EXPECT_GE(taken, kRounds);
}

TEST(SocketLock, NamesTheProcessThatDoesNotLetGo) {
  const testing::ScratchDirectory scratch;
  const auto held = SocketLock::Take(scratch / "cwm.sock");
  ASSERT_TRUE(held.ok());
  const auto second = SocketLock::Take(scratch / "cwm.sock");
  EXPECT_TRUE(absl::IsUnavailable(second.status())) << second.status();
  EXPECT_THAT(std::string(second.status().message()),
              HasSubstr("process " + std::to_string(getpid()) + " holds "));
}

TEST(SocketLock, SaysWhereNoFileCanBeMade) {
  const auto lock = SocketLock::Take("/nonexistent/cwm.sock");
  EXPECT_TRUE(absl::IsFailedPrecondition(lock.status())) << lock.status();
  EXPECT_THAT(std::string(lock.status().message()), HasSubstr("/nonexistent/cwm.sock.lock"));
}

}  // namespace
}  // namespace cwm::server
