// Other users of this machine at the viewer's port.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <memory>
#include <string>
#include <vector>

#include "tests/server/web/running_viewer.h"
#include "tests/support/other_user.h"

namespace cwm::server {
namespace {

using ::testing::HasSubstr;
using testing::kNobody;
using testing::OtherUser;
using testing::RawConnection;
using testing::RequestText;

constexpr char kUsersToken[] = "0123456789abcdef";

std::string StatusAndBody(const testing::HttpResponse& answer) {
  return std::to_string(answer.status) + " " + answer.body;
}

class UsersTest : public RunningViewer {
 protected:
  using RunningViewer::RunningViewer;

  void SetUp() override {
    if (!testing::CanBecomeOtherUser()) GTEST_SKIP() << "only root can become another user";
  }
  std::string AskedByNobody(const std::string& target) const {
    return OtherUser(kNobody, [&] { return StatusAndBody(SendRequest(target)); }).Result();
  }
};

TEST_F(UsersTest, AnotherUserIsRefusedEverywhereAndToldTheWayOut) {
  const std::string refusal = "403 user: is 65534, must be " + std::to_string(geteuid());
  for (const std::string& target :
       {std::string("/"), std::string("/viewer.js"), "/geometry/" + std::string(64, '0'),
        std::string("/nowhere"), std::string("/?token=") + kUsersToken}) {
    const std::string answer = AskedByNobody(target);
    EXPECT_THAT(answer, HasSubstr(refusal)) << target;
    EXPECT_THAT(answer, HasSubstr("CWM_VIEWER_TOKEN=TOKEN")) << target;
  }
  OtherUser opens_a_socket(
      kNobody, [&] { return std::to_string(testing::WebSocketClient(port()).status()); });
  EXPECT_EQ(opens_a_socket.Result(), "403");
  ExpectServes();
  EXPECT_EQ(testing::WebSocketClient(port()).status(), 101);
}

// A connection belongs to the user who made it, and ends after the refusal.
TEST_F(UsersTest, ARefusedConnectionEnds) {
  OtherUser asks_twice(kNobody, [&]() -> std::string {
    RawConnection connection(port());
    connection.Send(RequestText(port(), "GET", "/"));
    const int status = connection.Receive().status;
    return std::to_string(status) + (connection.Ends(std::chrono::seconds(5)) ? " ends" : " stays");
  });
  EXPECT_EQ(asks_twice.Result(), "403 ends");
}

class UsersWithToken : public UsersTest {
 protected:
  UsersWithToken() : UsersTest(ViewerLimits{}, kUsersToken) {}
};

TEST_F(UsersWithToken, WhoeverHasItLooks) {
  EXPECT_THAT(AskedByNobody("/"), HasSubstr("403 token: is absent"));
  EXPECT_EQ(AskedByNobody(std::string("/?token=") + kUsersToken), "200 <!doctype html>page");
}

class UsersInACrowd : public UsersTest {
 protected:
  static constexpr std::size_t kOfUser = 4;
  UsersInACrowd() : UsersTest({.connections = 2 * kOfUser, .connections_of_user = kOfUser}) {}
};

// Without the limit per user, the stranger could replace all other connections, this one included.
TEST_F(UsersInACrowd, WhoOpensManyConnectionsPushesOutNoneOfAnotherUsers) {
  RawConnection early(port());
  ASSERT_TRUE(early.Send(RequestText(port(), "GET", "/")));
  ASSERT_EQ(early.Receive().status, 200);
  OtherUser crowd(kNobody, [&]() -> std::string {
    std::vector<std::unique_ptr<RawConnection>> all;
    for (std::size_t i = 0; i < 4 * kOfUser; ++i) {
      all.push_back(std::make_unique<RawConnection>(port()));
    }
    int ended = 0;
    for (std::size_t i = 0; i < 3 * kOfUser; ++i) {
      ended += all[i]->Ends(std::chrono::seconds(5)) ? 1 : 0;
    }
    return std::to_string(ended) + " ended, the last " +
           (all.back()->Ends(std::chrono::milliseconds(200)) ? "ended" : "stays");
  });
  EXPECT_EQ(crowd.Result(), "12 ended, the last stays");
  ASSERT_TRUE(early.Send(RequestText(port(), "GET", "/")));
  EXPECT_EQ(early.Receive().status, 200);
  ExpectServes();
}

}  // namespace
}  // namespace cwm::server
