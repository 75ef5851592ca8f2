// Users of the machine at a loopback port of the gRPC server.
#include <gmock/gmock.h>

#include <chrono>
#include <fstream>
#include <sstream>
#include <thread>

#include "tests/e2e/user_programs.h"

namespace cwm::testing {
namespace {

constexpr int kUnavailable = 2;  // exit code, see `cwm --help`

class LoopbackUsers : public UserPrograms {
 protected:
  std::string Log() const {
    std::ostringstream text;
    text << std::ifstream(scratch_ / "log").rdbuf();
    return text.str();
  }

  // Starts a server as `user_` on both loopback addresses.
  void StartServer(const std::vector<std::string>& arguments) {
    std::vector<std::string> command = {"cwm-server",  "--viewer", "off",    "--listen",
                                        "127.0.0.1:0", "--listen", "[::1]:0"};
    command.insert(command.end(), arguments.begin(), arguments.end());
    server_ = std::make_unique<BackgroundProcess>(As(user_, command), scratch_ / "log");
    constexpr char kListens[] = " listens on ";
    for (int i = 0; i < 400 && server_->Running(); ++i) {
      const std::string log = Log();
      const std::size_t begin = log.find(kListens);
      const std::size_t end = log.find('\n', begin);
      if (begin != std::string::npos && end != std::string::npos) {
        std::istringstream words(log.substr(begin + sizeof(kListens) - 1, end - begin));
        for (std::string word; words >> word;) {
          if (word.back() == ',') word.pop_back();
          addresses_.push_back(word);
        }
        break;
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(25));
    }
    ASSERT_EQ(addresses_.size(), 2U) << Log();
  }
  ProcessResult Put(uid_t uid, const std::string& address) const {
    return Run(uid, {"cwm", "--addr", address, "--deadline", "5", "put", "box", "--box", "1,1,1",
                     "--at", "0,0,0"});
  }

  std::unique_ptr<BackgroundProcess> server_;
  std::vector<std::string> addresses_;
};

TEST_F(LoopbackUsers, AnotherUserIsRefusedAndTheServersUserAndRootAreNot) {
  ASSERT_NO_FATAL_FAILURE(StartServer({}));
  for (const std::string& address : addresses_) {
    for (const uid_t other : {stranger_, kNobody}) {
      EXPECT_EQ(Put(other, address).exit_code, kUnavailable) << address;
    }
    const ProcessResult objects = Run(user_, {"cwm", "--addr", address, "-o", "ndjson", "call",
                                              "cwm.v1.WorldService/ListWorlds", "{}"});
    EXPECT_EQ(objects.exit_code, 0) << objects.err;
    EXPECT_EQ(objects.out.find("default"), std::string::npos) << "nobody changed anything";
  }
  for (const std::string& address : addresses_) {
    for (const uid_t uid : {user_, uid_t{0}}) {
      const ProcessResult put = Put(uid, address);
      EXPECT_EQ(put.exit_code, 0) << address << " " << uid << put.err;
    }
  }
  EXPECT_EQ(server_->Stop(), 0);
}

TEST_F(LoopbackUsers, EveryUserIsAnsweredWhereTheServerWasToldSo) {
  ASSERT_NO_FATAL_FAILURE(StartServer({"--allow-any-local-user"}));
  for (const std::string& address : addresses_) {
    for (const uid_t uid : {stranger_, kNobody, user_, uid_t{0}}) {
      const ProcessResult put = Put(uid, address);
      EXPECT_EQ(put.exit_code, 0) << address << " " << uid << put.err;
    }
  }
  EXPECT_EQ(server_->Stop(), 0);
}

}  // namespace
}  // namespace cwm::testing
