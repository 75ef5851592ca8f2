#include "server/rpc/listen_address.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstring>
#include <fstream>

#include "tests/server/rpc/running_server.h"
#include "tests/support/process.h"

namespace cwm::server {
namespace {

using ::testing::HasSubstr;

TEST(ListenAddress, TakesUnixSocketsAndLoopback) {
  for (const char* address :
       {"unix:/tmp/x.sock", "127.0.0.1:50051", "127.8.9.1:0", "[::1]:5", "localhost:50051"}) {
    EXPECT_TRUE(CheckListenAddress(address).ok()) << address;
  }
}

TEST(ListenAddress, RefusesWhatOthersCouldReach) {
  for (const char* address : {"0.0.0.0:50051", "10.0.0.1:50051", ":50051", "[::]:50051",
                              "example.org:50051", "128.0.0.1:1"}) {
    const auto refused = CheckListenAddress(address);
    EXPECT_TRUE(absl::IsInvalidArgument(refused.status())) << address;
    EXPECT_THAT(std::string(refused.status().message()), HasSubstr("TLS")) << address;
  }
}

TEST(ListenAddress, RefusesWhatIsNoAddress) {
  for (const char* address : {"", "unix:", "127.0.0.1", "127.0.0.1:99999", "127.0.0.1:x"}) {
    EXPECT_FALSE(CheckListenAddress(address).ok()) << address;
  }
  EXPECT_FALSE(CheckListenAddress("unix:/" + std::string(200, 'a')).ok());
}

TEST(ListenAddress, ASocketThatNobodyAnswersOnIsRemoved) {
  const testing::ScratchDirectory scratch;
  const std::string path = scratch / "stale.sock";
  const int fd = socket(AF_UNIX, SOCK_STREAM, 0);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::memcpy(address.sun_path, path.data(), path.size());
  ASSERT_EQ(bind(fd, reinterpret_cast<sockaddr*>(&address), sizeof(address)), 0);
  close(fd);  // the file stays
  ASSERT_EQ(access(path.c_str(), F_OK), 0);
  EXPECT_TRUE(ClearStaleSocket("unix:" + path).ok());
  EXPECT_NE(access(path.c_str(), F_OK), 0);
}

TEST(ListenAddress, AFileIsNeverRemoved) {
  const testing::ScratchDirectory scratch;
  const std::string path = scratch / "notes.txt";
  std::ofstream(path) << "mine";
  EXPECT_TRUE(absl::IsFailedPrecondition(ClearStaleSocket("unix:" + path)));
  EXPECT_EQ(access(path.c_str(), F_OK), 0);
}

class ListenAddressServer : public RunningServer {};

TEST_F(ListenAddressServer, ASecondServerOnASocketIsRefusedAndTheFirstGoesOn) {
  Application other{.limits = {}, .retention = {}, .interpret = {}};
  const auto second = Server::Start(other, {address_});
  EXPECT_TRUE(absl::IsAlreadyExists(second.status())) << second.status();
  EXPECT_THAT(std::string(second.status().message()),
              HasSubstr("process " + std::to_string(getpid())));
  EXPECT_EQ(PutBox("a", 0), 1);
}

TEST_F(ListenAddressServer, TheSocketIsTheUsersAlone) {
  struct stat info {};
  ASSERT_EQ(stat((scratch_ / "cwm.sock").c_str(), &info), 0);
  EXPECT_EQ(info.st_mode & 0777, 0600u);
}

}  // namespace
}  // namespace cwm::server
