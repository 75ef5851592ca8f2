// Crowds of connections, a service manager and a stop, and their effects on the server's process.
#include <signal.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <cstring>
#include <fstream>
#include <optional>
#include <sstream>
#include <thread>

#include "tests/e2e/server_fixture.h"
#include "tests/support/raw_peer.h"

namespace cwm::testing {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr auto kSoon = std::chrono::seconds(20);

// A server of its own whose command is prefixed with `before`.
class Server {
 public:
  Server(std::vector<std::string> before, const std::vector<std::string>& options = {}) {
    std::vector<std::string> command = std::move(before);
    command.insert(command.end(),
                   {Program("cwm-server"), "--viewer", "off", "--listen", address()});
    command.insert(command.end(), options.begin(), options.end());
    process_.emplace(command, log());
  }
  std::string address() const { return "unix:" + scratch_ / "cwm.sock"; }
  std::string log() const { return scratch_ / "log"; }
  std::string Log() const {
    std::ostringstream text;
    text << std::ifstream(log()).rdbuf();
    return text.str();
  }
  bool Answers() const {
    return RunProgram({Program("cwm"), "--addr", address(), "status"}).exit_code == 0;
  }
  bool AnswersSoon() const {
    const auto until = Clock::now() + kSoon;
    while (Clock::now() < until && process_->Running()) {
      if (Answers()) return true;
      std::this_thread::sleep_for(milliseconds(25));
    }
    return false;
  }
  BackgroundProcess& process() { return *process_; }

 private:
  ScratchDirectory scratch_;
  std::optional<BackgroundProcess> process_;
};

std::vector<std::string> WithDescriptors(int count) {
  return {"/bin/sh", "-c", "ulimit -n " + std::to_string(count) + "; exec \"$@\"", "sh"};
}

TEST(ServerConnections, AFullTableOfDescriptorsIsSurvived) {
  Server server(WithDescriptors(64));
  ASSERT_TRUE(server.AnswersSoon()) << server.Log();
  for (int round = 0; round < 3; ++round) {
    std::vector<RawPeer> crowd;
    for (int i = 0; i < 129; ++i) crowd.emplace_back(server.address());
    if (round > 0) {
      for (const RawPeer& peer : crowd) peer.Send(Http2ClientPreface());
    }
    std::this_thread::sleep_for(milliseconds(200));
    crowd.clear();
    const auto begun = Clock::now();
    EXPECT_TRUE(server.AnswersSoon()) << server.Log();
    EXPECT_LT(Clock::now() - begun, std::chrono::seconds(5));
  }
  EXPECT_NE(server.Log().find("the process may have 64 file descriptors"), std::string::npos)
      << server.Log();
  EXPECT_EQ(server.process().Stop(), 0) << server.Log();
}

TEST(ServerConnections, ThousandsOfSilentPeersKeepNobodyOutAndGo) {
  Server server({});
  ASSERT_TRUE(server.AnswersSoon()) << server.Log();
  std::vector<RawPeer> silent;
  for (int i = 0; i < 1'200; ++i) silent.emplace_back(server.address());
  EXPECT_TRUE(server.Answers()) << "beside them";
  const auto begun = Clock::now();
  EXPECT_TRUE(silent.back().IsClosedWithin(kSoon));
  const auto time = Clock::now() - begun;
  EXPECT_GT(time, std::chrono::seconds(8));
  EXPECT_LT(time, std::chrono::seconds(15));
  EXPECT_TRUE(server.Answers());
  EXPECT_EQ(server.process().Stop(), 0) << server.Log();
}

// A service manager like systemd: a socket that receives datagrams.
class ServiceManager {
 public:
  ServiceManager() : fd_(socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::memcpy(address.sun_path, path().data(), path().size());
    EXPECT_EQ(bind(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof(address)), 0);
    const timeval time{.tv_sec = 20, .tv_usec = 0};
    setsockopt(fd_, SOL_SOCKET, SO_RCVTIMEO, &time, sizeof(time));
  }
  ~ServiceManager() { close(fd_); }
  ServiceManager(const ServiceManager&) = delete;
  ServiceManager& operator=(const ServiceManager&) = delete;

  std::string path() const { return scratch_ / "notify"; }
  // The next datagram; empty if none is received.
  std::string Next() const {
    std::array<char, 256> text{};
    const ssize_t size = recv(fd_, text.data(), text.size(), 0);
    return size > 0 ? std::string(text.data(), static_cast<std::size_t>(size)) : std::string();
  }

 private:
  ScratchDirectory scratch_;
  const int fd_;
};

TEST(ServerConnections, TheServiceManagerHearsThatItIsReadyThatItAnswersAndThatItStops) {
  const ServiceManager manager;
  Server server({"/usr/bin/env", "NOTIFY_SOCKET=" + manager.path(), "WATCHDOG_USEC=600000"});
  EXPECT_EQ(manager.Next(), "READY=1");
  EXPECT_TRUE(server.Answers()) << "it listens when it says so";
  for (int i = 0; i < 5; ++i) EXPECT_EQ(manager.Next(), "WATCHDOG=1") << server.Log();
  server.process().Signal(SIGTERM);
  std::string last = manager.Next();
  for (int i = 0; i < 100 && last == "WATCHDOG=1"; ++i) last = manager.Next();
  EXPECT_EQ(last, "STOPPING=1");
  EXPECT_EQ(server.process().Stop(), 0) << server.Log();
}

TEST(ServerConnections, TheServiceManagerHearsOfTheStoreBeforeItIsReady) {
  const ServiceManager manager;
  const ScratchDirectory scratch;
  Server server(
      {"/usr/bin/env", "NOTIFY_SOCKET=" + manager.path(), "CWM_STORE=sqlite:" + scratch / "store"});
  const std::string opening = manager.Next();
  EXPECT_EQ(opening.rfind("STATUS=opening the store\nEXTEND_TIMEOUT_USEC=", 0), 0U) << opening;
  std::string state = manager.Next();
  for (int i = 0; i < 200 && state.rfind("STATUS=replaying ", 0) == 0; ++i) {
    EXPECT_NE(state.find(" %\nEXTEND_TIMEOUT_USEC="), std::string::npos) << state;
    state = manager.Next();
  }
  EXPECT_EQ(state, "STATUS=serving");
  EXPECT_EQ(manager.Next(), "READY=1");
  EXPECT_TRUE(server.Answers());
  EXPECT_EQ(server.process().Stop(), 0) << server.Log();
}

TEST(ServerConnections, AnIdleCrowdOfPythonClientsDoesNotHoldUpAStop) {
  constexpr int kClients = 100;
  Server server({});
  ASSERT_TRUE(server.AnswersSoon()) << server.Log();
  const ScratchDirectory scratch;
  const std::string said = scratch / "said";
  BackgroundProcess clients(
      {"/usr/bin/python3", "tests/e2e/idle_clients.py", server.address(), std::to_string(kClients)},
      said);
  const auto are_idle = [&] {
    std::ostringstream text;
    text << std::ifstream(said).rdbuf();
    return text.str().find("idle\n") != std::string::npos;
  };
  const auto until = Clock::now() + std::chrono::minutes(1);
  while (!are_idle() && clients.Running() && Clock::now() < until) {
    std::this_thread::sleep_for(milliseconds(50));
  }
  ASSERT_TRUE(are_idle());
  const auto begun = Clock::now();
  EXPECT_EQ(server.process().Stop(), 0) << server.Log();
  const std::chrono::duration<double> time = Clock::now() - begun;
  RecordProperty("stop_idle_clients_s", std::to_string(time.count()));
  std::printf("stop_idle_clients_s %.3f (limit 1)\n", time.count());
  EXPECT_LT(time.count(), 1.0);
}

}  // namespace
}  // namespace cwm::testing
