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
#include "tests/support/other_user.h"
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

// Binds a socket at the path and leaves its file there.
void LeaveSocket(const std::string& path) {
  const int fd = socket(AF_UNIX, SOCK_STREAM, 0);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::memcpy(address.sun_path, path.data(), path.size());
  ASSERT_EQ(bind(fd, reinterpret_cast<sockaddr*>(&address), sizeof(address)), 0);
  close(fd);
}

TEST(ListenAddress, APathIsAsLongAsTheBoundNameAllows) {
  const std::string longest = "unix:/" + std::string(99, 'a');
  EXPECT_TRUE(CheckListenAddress(longest).ok());
  EXPECT_LT(SocketPath(BindingAddress(longest))->size(), sizeof(sockaddr_un::sun_path));
  EXPECT_THAT(std::string(CheckListenAddress(longest + "a").status().message()),
              HasSubstr("the path has 101 bytes, must have 1 to 100"));
}

TEST(ListenAddress, ASocketThatNobodyAnswersOnIsReplaced) {
  const testing::ScratchDirectory scratch;
  const std::string path = scratch / "stale.sock";
  LeaveSocket(path);
  const auto stale = FindSocket("unix:" + path);
  ASSERT_TRUE(stale.has_value());
  EXPECT_TRUE(CheckVacant("unix:" + path).ok());
  const std::string bound = BindingAddress("unix:" + path);
  LeaveSocket(*SocketPath(bound));
  EXPECT_TRUE(MoveIntoPlace(bound, "unix:" + path).ok());
  EXPECT_NE(FindSocket("unix:" + path), stale);
  EXPECT_FALSE(FindSocket(bound).has_value());
}

TEST(ListenAddress, ASocketWithoutAPlaceIsNotLeftBehind) {
  const testing::ScratchDirectory scratch;
  const std::string bound = scratch / "bound.sock";
  LeaveSocket(bound);
  const auto refused = MoveIntoPlace("unix:" + bound, "unix:" + (scratch / "none/cwm.sock"));
  EXPECT_TRUE(absl::IsUnavailable(refused)) << refused;
  EXPECT_NE(access(bound.c_str(), F_OK), 0);
}

TEST(ListenAddress, OnlyTheOwnSocketIsRemoved) {
  const testing::ScratchDirectory scratch;
  const std::string path = scratch / "cwm.sock";
  LeaveSocket(path);
  const auto own = FindSocket("unix:" + path);
  ASSERT_TRUE(own.has_value());
  LeaveSocket(path + ".next");
  ASSERT_TRUE(MoveIntoPlace("unix:" + path + ".next", "unix:" + path).ok());
  RemoveSocket("unix:" + path, *own);
  const auto next = FindSocket("unix:" + path);
  ASSERT_TRUE(next.has_value());
  RemoveSocket("unix:" + path, *next);
  EXPECT_FALSE(FindSocket("unix:" + path).has_value());
}

TEST(ListenAddress, AFileIsNeverReplaced) {
  const testing::ScratchDirectory scratch;
  const std::string path = scratch / "notes.txt";
  std::ofstream(path) << "mine";
  EXPECT_TRUE(absl::IsFailedPrecondition(CheckVacant("unix:" + path)));
  EXPECT_EQ(access(path.c_str(), F_OK), 0);
}

TEST(ListenAddress, ASocketOfAnotherUserIsSaidToBeTheirs) {
  if (!testing::CanBecomeOtherUser()) GTEST_SKIP() << "only root can make a socket another user's";
  const testing::ScratchDirectory scratch;
  const std::string path = scratch / "cwm.sock";
  ASSERT_EQ(chmod(scratch.path().c_str(), 01777), 0);
  const int fd = socket(AF_UNIX, SOCK_STREAM, 0);
  sockaddr_un name{};
  name.sun_family = AF_UNIX;
  path.copy(name.sun_path, sizeof(name.sun_path) - 1);
  ASSERT_EQ(bind(fd, reinterpret_cast<const sockaddr*>(&name), sizeof(name)), 0);
  ASSERT_EQ(listen(fd, 8), 0);
  ASSERT_EQ(chown(path.c_str(), 1, 1), 0);
  const absl::Status live = CheckVacant("unix:" + path);
  EXPECT_TRUE(absl::IsAlreadyExists(live)) << live;
  EXPECT_THAT(std::string(live.message()), HasSubstr(", of user 1"));
  close(fd);
  EXPECT_TRUE(CheckVacant("unix:" + path).ok()) << "root may replace it";
  testing::OtherUser user(testing::kNobody,
                          [&] { return std::string(CheckVacant("unix:" + path).message()); });
  EXPECT_THAT(user.Result(), HasSubstr("a socket lies there, of user 1: listen in a directory"));
}

class ListenAddressServer : public RunningServer {};

TEST_F(ListenAddressServer, ASecondServerOnASocketIsRefusedAndTheFirstGoesOn) {
  Application other{.limits = {}, .retention = {}, .interpret = {}};
  const auto second = Server::Start(other, {.addresses = {address_}});
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
