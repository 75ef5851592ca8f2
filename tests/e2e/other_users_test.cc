// Other users of the machine: at a default address that they took first, and at the viewer.
#include <gmock/gmock.h>

#include <chrono>
#include <cstring>
#include <fstream>
#include <thread>

#include "tests/e2e/user_programs.h"
#include "tests/support/web_client.h"

namespace cwm::testing {
namespace {

using ::testing::HasSubstr;

constexpr int kUnavailable = 2;  // exit codes, see `cwm --help`
constexpr int kPermission = 6;

class DefaultAddressTest : public UserPrograms {
 protected:
  void TearDown() override { std::filesystem::remove_all(folder_); }

  // Starts a server and waits until it answers `who` at the address.
  void StartServer(uid_t who, const std::vector<std::string>& arguments,
                   const std::vector<std::string>& status) {
    std::vector<std::string> command = {"cwm-server", "--viewer", "off"};
    command.insert(command.end(), arguments.begin(), arguments.end());
    server_ = std::make_unique<BackgroundProcess>(As(who, command), scratch_ / "log");
    for (int i = 0; i < 400 && server_->Running(); ++i) {
      if (Run(who, status).exit_code == 0) return;
      std::this_thread::sleep_for(std::chrono::milliseconds(25));
    }
    std::ifstream log(scratch_ / "log");
    FAIL() << std::string(std::istreambuf_iterator<char>(log), {});
  }

  const std::string folder_ = "/tmp/cwm-" + std::to_string(user_);
  const std::string socket_ = "unix:" + folder_ + "/cwm.sock";
  std::unique_ptr<BackgroundProcess> server_;
};

TEST_F(DefaultAddressTest, ServerAndClientsOfAUserMeetInAFolderOfTheirOwn) {
  ASSERT_NO_FATAL_FAILURE(StartServer(user_, {}, {"cwm", "status"}));
  struct stat info {};
  ASSERT_EQ(lstat(folder_.c_str(), &info), 0);
  EXPECT_EQ(info.st_mode & 07777, 0700U);
  EXPECT_EQ(info.st_uid, user_);
  EXPECT_THAT(Run(user_, {"cwm", "status"}).out, HasSubstr(socket_));
  EXPECT_EQ(Run(stranger_, {"cwm", "--addr", socket_, "status"}).exit_code, kUnavailable);
  EXPECT_EQ(server_->Stop(), 0);
}

TEST_F(DefaultAddressTest, AFolderThatAStrangerMadeIsNotBelieved) {
  ASSERT_EQ(mkdir(folder_.c_str(), 0755), 0);
  ASSERT_EQ(chown(folder_.c_str(), stranger_, stranger_), 0);
  ASSERT_NO_FATAL_FAILURE(
      StartServer(stranger_, {"--listen", socket_}, {"cwm", "--addr", socket_, "status"}));
  ASSERT_EQ(chmod((folder_ + "/cwm.sock").c_str(), 0777), 0);
  const std::string why = folder_ + ": belongs to user " + std::to_string(stranger_) +
                          ", must belong to user " + std::to_string(user_);
  const std::string way_out =
      "choose an address with CWM_ADDR, --listen (server) or --addr (client)";
  for (const std::vector<std::string>& command :
       {std::vector<std::string>{"cwm", "status"},
        std::vector<std::string>{"cwm", "put", "a", "--box", "1,1,1", "--at", "0,0,0"}}) {
    const ProcessResult run = Run(user_, command);
    EXPECT_EQ(run.exit_code, kPermission) << run.out;
    EXPECT_THAT(run.err, HasSubstr(why));
    EXPECT_THAT(run.err, HasSubstr(way_out));
  }
  const ProcessResult server = Run(user_, {"cwm-server", "--viewer", "off"});
  EXPECT_EQ(server.exit_code, kUnavailable);
  EXPECT_THAT(server.err, HasSubstr(why));
  EXPECT_THAT(server.err, HasSubstr(way_out));
  // The stranger's server does answer a client that names its address explicitly.
  EXPECT_EQ(Run(user_, {"cwm", "--addr", socket_, "status"}).exit_code, 0);
  EXPECT_EQ(server_->Stop(), 0);
}

TEST_F(DefaultAddressTest, AFolderThatIsOpenToOthersIsRefused) {
  ASSERT_EQ(mkdir(folder_.c_str(), 0700), 0);
  ASSERT_EQ(chown(folder_.c_str(), user_, user_), 0);
  ASSERT_EQ(chmod(folder_.c_str(), 0770), 0);
  const std::string why = folder_ + ": has mode 0770, must have 0700";
  EXPECT_THAT(Run(user_, {"cwm", "status"}).err, HasSubstr(why));
  EXPECT_THAT(Run(user_, {"cwm-server", "--viewer", "off"}).err, HasSubstr(why));
}

TEST_F(DefaultAddressTest, ARuntimeDirectoryThatOthersWriteToIsRefused) {
  for (const char* program : {"cwm", "cwm-server"}) {
    std::vector<std::string> command = As(user_, {program, "status"});
    if (std::strcmp(program, "cwm-server") == 0) command.back() = "--viewer=off";
    command.insert(command.end() - 2, {"env", "XDG_RUNTIME_DIR=/tmp"});
    const ProcessResult run = RunProgram(command);
    EXPECT_NE(run.exit_code, 0);
    EXPECT_THAT(run.err, HasSubstr("XDG_RUNTIME_DIR: /tmp: has mode 1777, must not be writable"));
  }
}

// A server that was told to listen in a world-writable folder.
TEST_F(DefaultAddressTest, ALockThatAStrangerHoldsIsNamed) {
  const std::string shared = scratch_ / "shared";
  ASSERT_EQ(mkdir(shared.c_str(), 0700), 0);
  ASSERT_EQ(chmod(shared.c_str(), 01777), 0);
  const std::string lock = shared + "/cwm.sock.lock";
  for (const mode_t mode : {0600U, 0666U}) {
    std::ofstream(lock).close();
    ASSERT_EQ(chmod(lock.c_str(), mode), 0);
    ASSERT_EQ(chown(lock.c_str(), stranger_, stranger_), 0);
    const ProcessResult run =
        Run(user_, {"cwm-server", "--viewer=off", "--listen", "unix:" + shared + "/cwm.sock"});
    EXPECT_EQ(run.exit_code, kUnavailable);
    EXPECT_THAT(run.err, HasSubstr(lock + ": it belongs to user " + std::to_string(stranger_)));
  }
}

class ViewerUsersTest : public ServerTest {
 protected:
  std::string viewer() const override { return "127.0.0.1:0"; }
};

TEST_F(ViewerUsersTest, AnotherUserSeesNothingOfTheWorld) {
  if (!CanBecomeOtherUser()) GTEST_SKIP() << "only root can become another user";
  const int port = ViewerPort();
  ASSERT_GT(port, 0) << ServerLog();
  EXPECT_EQ(SendRequest(port, "/").status, 200);
  EXPECT_EQ(WebSocketClient(port).status(), 101);
  for (const char* target : {"/", "/viewer.js", "/socket"}) {
    OtherUser stranger(kNobody, [&] {
      const HttpResponse answer = SendRequest(port, target);
      return std::to_string(answer.status) + " " + answer.body;
    });
    const std::string answer = stranger.Result();
    EXPECT_THAT(answer, HasSubstr("403 user: is 65534, must be 0"));
    EXPECT_THAT(answer, HasSubstr("CWM_VIEWER_TOKEN=TOKEN"));
  }
  OtherUser opens_a_socket(kNobody, [&] { return std::to_string(WebSocketClient(port).status()); });
  EXPECT_EQ(opens_a_socket.Result(), "403");
  EXPECT_EQ(SendRequest(port, "/").status, 200);
}

}  // namespace
}  // namespace cwm::testing
