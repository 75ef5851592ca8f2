#include "server/rpc/socket_lock.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <fstream>
#include <optional>
#include <sstream>
#include <thread>
#include <vector>

#include "tests/support/other_user.h"
#include "tests/support/process.h"

namespace cwm::server {
namespace {

using ::testing::HasSubstr;

TEST(SocketLock, LeavesNoFileBehindAndCanBeTakenAgain) {
  const testing::ScratchDirectory scratch;
  const std::string path = scratch / "cwm.sock";
  for (int i = 0; i < 2; ++i) {
    const auto lock = SocketLock::Acquire(path);
    ASSERT_TRUE(lock.ok()) << lock.status();
    EXPECT_EQ(access((path + ".lock").c_str(), F_OK), 0);
  }
  EXPECT_NE(access((path + ".lock").c_str(), F_OK), 0);
}

// Each thread repeatedly creates, locks and removes the file: at no time do two hold the lock.
TEST(SocketLock, IsHeldByOneAtATimeThoughItsFileComesAndGoes) {
  constexpr int kThreads = 8;
  constexpr int kRounds = 100;
  const testing::ScratchDirectory scratch;
  const std::string path = scratch / "cwm.sock";
  std::atomic<int> holders = 0;
  std::atomic<int> taken = 0;
  std::atomic<int> max_holders = 0;
  {
    std::vector<std::jthread> threads;
    for (int i = 0; i < kThreads; ++i) {
      threads.emplace_back([&] {
        for (int round = 0; round < kRounds; ++round) {
          const auto lock = SocketLock::Acquire(path);
          if (!lock.ok()) continue;  // timed out on a busy machine
          ++taken;
          const int now = ++holders;
          if (now > max_holders) max_holders = now;
          std::this_thread::yield();
          --holders;
        }
      });
    }
  }
  EXPECT_EQ(max_holders, 1);
  EXPECT_GE(taken, kRounds);
}

TEST(SocketLock, NamesTheProcessThatDoesNotLetGo) {
  const testing::ScratchDirectory scratch;
  const auto held = SocketLock::Acquire(scratch / "cwm.sock");
  ASSERT_TRUE(held.ok());
  const auto second = SocketLock::Acquire(scratch / "cwm.sock");
  EXPECT_TRUE(absl::IsUnavailable(second.status())) << second.status();
  EXPECT_THAT(std::string(second.status().message()),
              HasSubstr("process " + std::to_string(getpid()) + " holds "));
}

TEST(SocketLock, SaysWhereNoFileCanBeMade) {
  const auto lock = SocketLock::Acquire("/nonexistent/cwm.sock");
  EXPECT_TRUE(absl::IsFailedPrecondition(lock.status())) << lock.status();
  EXPECT_THAT(std::string(lock.status().message()), HasSubstr("/nonexistent/cwm.sock.lock"));
}

class SocketLockOfStranger : public ::testing::Test {
 protected:
  // The reason why the lock is refused.
  std::string Refusal() {
    const auto lock = SocketLock::Acquire(socket_);
    EXPECT_TRUE(absl::IsFailedPrecondition(lock.status())) << lock.status();
    return std::string(lock.status().message());
  }
  static std::string Text(const std::string& path) {
    std::ostringstream text;
    text << std::ifstream(path).rdbuf();
    return text.str();
  }

  const testing::ScratchDirectory scratch_;
  const std::string socket_ = scratch_ / "cwm.sock";
  const std::string file_ = socket_ + ".lock";
};

// In a world-writable directory another user may have created the file first.
TEST_F(SocketLockOfStranger, AFileOfAnotherUserIsNotBelievedAndNotWrittenTo) {
  if (!testing::CanBecomeOtherUser()) GTEST_SKIP() << "only root can make a file another user's";
  ASSERT_EQ(chmod(scratch_.path().c_str(), 01777), 0);
  testing::OtherUser stranger(testing::kNobody, [&]() -> std::string {
    std::ofstream(file_) << "theirs";
    const int fd = open(file_.c_str(), O_RDWR | O_CLOEXEC);
    return flock(fd, LOCK_EX | LOCK_NB) == 0 && Text(file_) == "theirs" ? "held" : "";
  });
  ASSERT_EQ(stranger.Result(), "held");
  EXPECT_THAT(Refusal(), HasSubstr("cannot lock " + file_ +
                                   ": it belongs to user 65534, must belong to user 0: remove it"));
  EXPECT_EQ(Text(file_), "theirs");
}

TEST_F(SocketLockOfStranger, AnotherFileOfOursIsNotOverwrittenByWayOfALink) {
  const std::string precious = scratch_ / "precious";
  std::ofstream(precious) << "mine";
  ASSERT_EQ(link(precious.c_str(), file_.c_str()), 0);
  EXPECT_THAT(Refusal(), HasSubstr("it is a hard link to another file"));
  ASSERT_EQ(unlink(file_.c_str()), 0);
  ASSERT_EQ(symlink(precious.c_str(), file_.c_str()), 0);
  EXPECT_THAT(Refusal(), HasSubstr("it is no regular file"));
  EXPECT_EQ(Text(precious), "mine");
  ASSERT_EQ(unlink(file_.c_str()), 0);
  ASSERT_EQ(mkfifo(file_.c_str(), 0600), 0);
  EXPECT_THAT(Refusal(), HasSubstr("it is no regular file"));
}

}  // namespace
}  // namespace cwm::server
