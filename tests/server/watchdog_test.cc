#include "server/watchdog.h"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cstdlib>
#include <cstring>
#include <string>
#include <thread>

#include "server/rpc/listener.h"
#include "server/rpc/self_check.h"
#include "server/service_manager.h"
#include "tests/server/rpc/running_server.h"

namespace cwm::server {
namespace {

using std::chrono::milliseconds;

constexpr auto kPeriod = milliseconds(100);
constexpr auto kSoon = std::chrono::seconds(10);

class WatchdogTest : public RunningServer {};

TEST_F(WatchdogTest, TellsAgainAndAgainThatTheServerAnswers) {
  std::atomic<int> notifications = 0;
  const Watchdog watchdog(
      kPeriod, [this](milliseconds) { return server_->CheckItself(kSoon); },
      [&] { ++notifications; });
  const auto until = Clock::now() + kSoon;
  while (notifications < 5 && Clock::now() < until) std::this_thread::sleep_for(kPeriod);
  EXPECT_GE(notifications, 5);
}

TEST_F(WatchdogTest, SaysNothingMoreOnceTheServerHasStopped) {
  std::atomic<int> notifications = 0;
  const Watchdog watchdog(
      kPeriod, [this](milliseconds) { return CheckHealth(address_, kSoon); },
      [&] { ++notifications; });
  const auto until = Clock::now() + kSoon;
  while (notifications < 1 && Clock::now() < until) std::this_thread::sleep_for(kPeriod);
  ASSERT_GE(notifications, 1);
  server_->Stop(kSoon);
  std::this_thread::sleep_for(kPeriod);  // waits for a notification in progress
  const int before = notifications;
  std::this_thread::sleep_for(5 * kPeriod);
  EXPECT_EQ(notifications, before);
}

// A listener that has stopped accepting: connections are made, but nobody answers.
TEST(StuckListenerTest, SaysNothingWhereNobodyAccepts) {
  const testing::ScratchDirectory scratch;
  for (const std::string& address : {"unix:" + (scratch / "s"), std::string("127.0.0.1:0")}) {
    const auto listener = Listen(address, kSoon);
    ASSERT_TRUE(listener.ok()) << listener.status();
    std::atomic<int> notifications = 0;
    std::atomic<int> checked = 0;
    const auto begun = Clock::now();
    {
      const Watchdog watchdog(
          kPeriod,
          [&](milliseconds timeout) {
            ++checked;
            return CheckHealth(listener->address, timeout);
          },
          [&] { ++notifications; });
      std::this_thread::sleep_for(10 * kPeriod);
    }
    EXPECT_EQ(notifications, 0) << address;
    EXPECT_GE(checked, 2) << address;
    EXPECT_LT(Clock::now() - begun, kSoon) << "no check takes longer than its time";
  }
}

TEST(CheckHealthTest, SaysWhyNobodyIsReached) {
  const testing::ScratchDirectory scratch;
  const absl::Status status = CheckHealth("unix:" + (scratch / "nobody"), kSoon);
  EXPECT_NE(status.message().find("nobody: No such file or directory"), std::string::npos)
      << status;
}

// Sets an environment variable for its lifetime.
class Environment {
 public:
  Environment(const char* name, const std::string& value) : name_(name) {
    setenv(name, value.c_str(), 1);
  }
  ~Environment() { unsetenv(name_); }
  Environment(const Environment&) = delete;
  Environment& operator=(const Environment&) = delete;

 private:
  const char* const name_;
};

TEST(ServiceManagerTest, GetsADatagramAtAPathOrAnAbstractName) {
  const testing::ScratchDirectory scratch;
  for (const std::string& name : {scratch / "notify", "@cwm-test-" + std::to_string(getpid())}) {
    const FileDescriptor manager(socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0));
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::memcpy(address.sun_path, name.data(), name.size());
    if (name.front() == '@') address.sun_path[0] = '\0';
    const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + name.size());
    ASSERT_EQ(bind(manager.number(), reinterpret_cast<const sockaddr*>(&address), size), 0);
    const Environment environment("NOTIFY_SOCKET", name);
    ASSERT_TRUE(NotifyServiceManager("READY=1")) << name;
    std::array<char, 64> text{};
    const ssize_t received = recv(manager.number(), text.data(), text.size(), MSG_DONTWAIT);
    EXPECT_EQ(std::string(text.data(), static_cast<std::size_t>(std::max<ssize_t>(received, 0))),
              "READY=1");
  }
}

TEST(ServiceManagerTest, NobodyIsToldWhereNobodyListens) {
  EXPECT_FALSE(NotifyServiceManager("READY=1"));
  const Environment environment("NOTIFY_SOCKET", "/nowhere/at/all");
  EXPECT_FALSE(NotifyServiceManager("READY=1"));
}

TEST(ServiceManagerTest, TheWatchdogsTimeIsThisProcessesAlone) {
  EXPECT_EQ(WatchdogTime(), std::nullopt);
  const Environment time("WATCHDOG_USEC", "30000000");
  EXPECT_EQ(WatchdogTime(), std::chrono::seconds(30));
  {
    const Environment own("WATCHDOG_PID", std::to_string(getpid()));
    EXPECT_EQ(WatchdogTime(), std::chrono::seconds(30));
  }
  const Environment another("WATCHDOG_PID", "1");
  EXPECT_EQ(WatchdogTime(), std::nullopt);
  for (const char* wrong : {"", "0", "-1", "soon"}) {
    const Environment no_time("WATCHDOG_USEC", wrong);
    EXPECT_EQ(WatchdogTime(), std::nullopt) << wrong;
  }
}

}  // namespace
}  // namespace cwm::server
