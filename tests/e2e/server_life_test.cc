// Starting, stopping and sharing a machine with others.
#include <signal.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <chrono>
#include <cstring>
#include <fstream>
#include <sstream>
#include <thread>

#include "tests/e2e/server_fixture.h"

namespace cwm::testing {
namespace {

using nlohmann::json;

class ServerLife : public ServerTest {};

TEST_F(ServerLife, HelpBeginsWithExamples) {
  for (const char* program : {"cwm-server", "cwm-simulator", "cwm"}) {
    const ProcessResult help = RunProgram({Program(program), "--help"});
    EXPECT_EQ(help.exit_code, 0);
    const std::size_t examples = help.out.find(std::string("\n\nExamples:\n  ") + program);
    EXPECT_NE(examples, std::string::npos) << help.out;
    EXPECT_LT(examples, help.out.find("Usage:"));
  }
}

TEST_F(ServerLife, SocketIsThereForItsOwnerAlone) {
  struct stat info = {};
  ASSERT_EQ(stat(address().substr(5).c_str(), &info), 0);
  EXPECT_EQ(info.st_mode & 077, 0U);
}

TEST_F(ServerLife, ASecondServerOnTheSameSocketIsRefused) {
  const ProcessResult second = RunProgram({Program("cwm-server"), "--listen", address()});
  EXPECT_NE(second.exit_code, 0);
  EXPECT_NE(second.err.find("cwm.sock"), std::string::npos) << second.err;
  EXPECT_EQ(Cwm({"status"}).exit_code, 0) << "the first one must not have been disturbed";
}

TEST_F(ServerLife, ASocketLeftBehindByACrashIsTakenOver) {
  const ScratchDirectory other;
  const std::string socket = "unix:" + other / "left.sock";
  {
    BackgroundProcess crashing({Program("cwm-server"), "--listen", socket}, other / "log");
    for (int i = 0;
         i < 200 && RunProgram({Program("cwm"), "--addr", socket, "status"}).exit_code != 0; ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(25));
    }
    crashing.Signal(SIGKILL);
  }
  BackgroundProcess next({Program("cwm-server"), "--listen", socket}, other / "log");
  int exit_code = 1;
  for (int i = 0; i < 200 && exit_code != 0; ++i) {
    exit_code = RunProgram({Program("cwm"), "--addr", socket, "status"}).exit_code;
    std::this_thread::sleep_for(std::chrono::milliseconds(25));
  }
  EXPECT_EQ(exit_code, 0);
  EXPECT_EQ(next.Stop(), 0);
}

// Leaves a socket file on which nobody listens.
void LeaveStaleSocket(const std::string& path) {
  const int fd = socket(AF_UNIX, SOCK_STREAM, 0);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  ASSERT_LT(path.size(), sizeof(address.sun_path));
  std::memcpy(address.sun_path, path.data(), path.size());
  ASSERT_EQ(bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof(address)), 0);
  close(fd);
}

std::string TextOf(const std::string& path) {
  std::ostringstream text;
  text << std::ifstream(path).rdbuf();
  return text.str();
}

TEST_F(ServerLife, OfTwoThatStartTogetherOnAStaleSocketExactlyOneWinsAndTheOtherNamesIt) {
  constexpr int kRounds = 20;
  for (int round = 0; round < kRounds; ++round) {
    SCOPED_TRACE(round);
    const ScratchDirectory place;
    const std::string path = place / "cwm.sock";
    LeaveStaleSocket(path);
    const std::vector<std::string> command = {Program("cwm-server"), "--listen", "unix:" + path};
    const std::string logs[] = {place / "log0", place / "log1"};
    BackgroundProcess one(command, logs[0]);
    BackgroundProcess two(command, logs[1]);
    // One of them ends by itself.
    for (int i = 0; i < 2000 && one.Running() && two.Running(); ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    ASSERT_NE(one.Running(), two.Running());
    BackgroundProcess& winner = one.Running() ? one : two;
    const std::string said = TextOf(one.Running() ? logs[1] : logs[0]);
    EXPECT_NE(said.find("a server is running there already, process " +
                        std::to_string(winner.pid()) + "\n"),
              std::string::npos)
        << said;
    const std::vector<std::string> ask = {Program("cwm"), "--addr", "unix:" + path, "status"};
    EXPECT_EQ(RunProgram(ask).exit_code, 0) << "the winner answers on the socket";
    EXPECT_TRUE(winner.Running());
    EXPECT_NE(access((path + ".lock").c_str(), F_OK), 0) << "no file is left behind";
    EXPECT_EQ(winner.Stop(), 0);
  }
}

TEST_F(ServerLife, WithoutAServerTheExitCodeSaysUnavailable) {
  const ProcessResult run =
      RunProgram({Program("cwm"), "--addr", "unix:" + scratch() / "nobody.sock", "status"});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_NE(run.err.find("nobody.sock"), std::string::npos) << run.err;
}

TEST_F(ServerLife, AWatchSeesEveryChangeInOrderAndResumes) {
  ASSERT_EQ(Cwm({"put", "a", "--sphere", "0.1", "--at", "0,0,1"}).exit_code, 0);
  BackgroundProcess watch({Program("cwm"), "--addr", address(), "-o", "ndjson", "watch"},
                          scratch() / "watch.log");
  const auto lines = [&](const std::string& path) {
    std::ifstream file(path);
    std::vector<json> steps;
    for (std::string line; std::getline(file, line);) {
      json step = json::parse(line, nullptr, false);
      if (!step.is_discarded()) steps.push_back(std::move(step));
    }
    return steps;
  };
  const auto wait_for = [&](const std::string& path, std::int64_t revision) {
    for (int i = 0; i < 400; ++i) {
      const auto steps = lines(path);
      if (!steps.empty() && std::stoll(steps.back().at("revision").get<std::string>()) >= revision)
        return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(25));
    }
    return false;
  };
  ASSERT_TRUE(wait_for(scratch() / "watch.log", 1));
  ASSERT_EQ(Cwm({"put", "b", "--box", "0.1,0.1,0.1", "--at", "1,0,1"}).exit_code, 0);
  ASSERT_EQ(Cwm({"move", "a", "--at", "0,0,2"}).exit_code, 0);
  ASSERT_EQ(Cwm({"remove", "b"}).exit_code, 0);
  ASSERT_TRUE(wait_for(scratch() / "watch.log", 4));
  // The initial state, then each revision once and in order.
  std::vector<std::int64_t> told;
  for (const json& step : lines(scratch() / "watch.log")) {
    const std::int64_t revision = std::stoll(step.at("revision").get<std::string>());
    if (told.empty() || told.back() != revision) told.push_back(revision);
  }
  EXPECT_EQ(told, (std::vector<std::int64_t>{1, 2, 3, 4}));
  watch.Stop();

  BackgroundProcess resumed({Program("cwm"), "--addr", address(), "-o", "ndjson", "watch", "--from",
                             "2", "--world-uid", UidOf("default")},
                            scratch() / "resumed.log");
  ASSERT_TRUE(wait_for(scratch() / "resumed.log", 4));
  const json first = lines(scratch() / "resumed.log").front();
  EXPECT_EQ(first.at("revision"), "3");
  EXPECT_EQ(first.at("events").at("events").at(0).at("move").at("name"), "a");
}

}  // namespace
}  // namespace cwm::testing
