#include "server/web/access.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "server/web/readable_methods.h"
#include "server/web/viewer_address.h"

namespace cwm::server {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr char kToken[] = "0123456789abcdef";

HttpRequest RequestTo(const std::string& host, const std::string& target = "/") {
  HttpRequest request(http::verb::get, target, 11);
  if (!host.empty()) request.insert(http::field::host, host);
  return request;
}

Access Loopback(const std::string& token = "") {
  return Access({"localhost", 8640}, {"127.0.0.1", 8640}, token);
}

TEST(Access, HostsThatAreThisServerAreLetIn) {
  for (const char* host : {"127.0.0.1:8640", "localhost:8640", "LocalHost:8640", "[::1]:8640"}) {
    EXPECT_FALSE(Loopback().CheckHost(RequestTo(host)).has_value()) << host;
  }
}

// The owner of "robot" in some network that the laptop visits could make the name lead here, and on
// loopback there is no token.
TEST(Access, OnLoopbackItsOwnNamesAndAddressesAreLetInAlone) {
  const ThisMachine robot{.names = {"robot.lab.example", "robot", "robot.local"},
                          .addresses = {"192.168.1.7"}};
  struct Case {
    ViewerAddress requested;
    ViewerAddress bound;
  };
  for (const Case& one :
       {Case{{"127.0.0.1", 8640}, {"127.0.0.1", 8640}}, Case{{"::1", 8640}, {"::1", 8640}},
        Case{{"localhost", 8640}, {"127.0.0.1", 8640}},
        Case{{"robot", 8640}, {"127.0.1.1", 8640}}}) {  // as in Debian's /etc/hosts
    const Access access(one.requested, one.bound, "", robot);
    SCOPED_TRACE(one.requested.Text() + " " + one.bound.Text());
    for (const char* host : {"localhost:8640", "127.0.0.1:8640", "127.0.1.1:8640",
                             "127.255.255.254:8640", "[::1]:8640"}) {
      EXPECT_FALSE(access.CheckHost(RequestTo(host)).has_value()) << host;
    }
    for (const char* host :
         {"robot:8640", "robot.local:8640", "robot.lab.example:8640", "192.168.1.7:8640",
          "128.0.0.1:8640", "126.255.255.255:8640", "0.0.0.0:8640", "[::]:8640", "127.1:8640",
          "127.0.0.1.evil.example:8640", "[::ffff:127.0.0.1]:8640", "127.0.1.1:8641"}) {
      const auto refusal = access.CheckHost(RequestTo(host));
      ASSERT_TRUE(refusal.has_value()) << host;
      EXPECT_NE(refusal->why.find("another of 127.0.0.0/8 with :8640"), std::string::npos)
          << refusal->why;
    }
    for (const std::string& url : access.Urls()) {
      const std::string host = url.substr(7, url.size() - 8);
      EXPECT_FALSE(access.CheckHost(RequestTo(host)).has_value()) << url;
    }
  }
}

TEST(Access, OnAnAddressOfANetworkTheMachinesNamesAreLetIn) {
  const Access access({"192.168.1.7", 8640}, {"192.168.1.7", 8640}, kToken,
                      {.names = {"robot", "robot.local"}});
  for (const char* host : {"192.168.1.7:8640", "robot:8640", "robot.local:8640"}) {
    EXPECT_FALSE(access.CheckHost(RequestTo(host)).has_value()) << host;
  }
  EXPECT_TRUE(access.CheckHost(RequestTo("192.168.1.8:8640")).has_value());
}

TEST(Access, OtherHostsAreRefusedAndTheRuleIsSaid) {
  for (const char* host : {"evil.example:8640", "evil.example", "127.0.0.1", "127.0.0.1:8641", "",
                           "localhost:8640.evil.example", "127.0.0.1:8640@evil.example", "[::1]",
                           "192.168.1.7:8640", "0x7f000001:8640"}) {
    const auto refusal = Loopback().CheckHost(RequestTo(host));
    ASSERT_TRUE(refusal.has_value()) << host;
    EXPECT_EQ(refusal->status, http::status::forbidden);
    EXPECT_NE(refusal->why.find("must be one of localhost:8640, 127.0.0.1:8640, [::1]:8640"),
              std::string::npos)
        << refusal->why;
  }
  HttpRequest twice = RequestTo("127.0.0.1:8640");
  twice.insert(http::field::host, "127.0.0.1:8640");
  EXPECT_NE(Loopback().CheckHost(twice)->why.find("more than once"), std::string::npos);
}

TEST(Access, TheHttpPortNeedNotBeNamed) {
  const Access access({"127.0.0.1", 80}, {"127.0.0.1", 80}, "");
  EXPECT_FALSE(access.CheckHost(RequestTo("127.0.0.1")).has_value());
  EXPECT_FALSE(access.CheckHost(RequestTo("[::1]")).has_value());
  EXPECT_FALSE(access.CheckHost(RequestTo("127.0.0.1:80")).has_value());
  EXPECT_TRUE(access.CheckHost(RequestTo("evil.example")).has_value());
}

TEST(Access, OfAllInterfacesAddressesAreLetInAndForeignNamesAreNot) {
  const Access access({"0.0.0.0", 8640}, {"0.0.0.0", 8640}, kToken,
                      {.names = {"robot.lab.example", "robot", "robot.local"}});
  for (const char* host :
       {"robot:8640", "Robot.local:8640", "robot.lab.example:8640", "localhost:8640"}) {
    EXPECT_FALSE(access.CheckHost(RequestTo(host)).has_value()) << host;
  }
  for (const char* host : {"robot.evil.example:8640", "robot", "robot.local.:8640",
                           "robot.localevil:8640", "robot:8641"}) {
    EXPECT_TRUE(access.CheckHost(RequestTo(host)).has_value()) << host;
  }
  EXPECT_EQ(access.CheckHost(RequestTo("evil.example"))->why,
            "Host: is \"evil.example\", must be one of localhost:8640, 127.0.0.1:8640, [::1]:8640, "
            "robot.lab.example:8640, robot:8640, robot.local:8640, ADDRESS:8640");
  EXPECT_FALSE(access.CheckHost(RequestTo("192.168.1.7:8640")).has_value());
  EXPECT_FALSE(access.CheckHost(RequestTo("[fe80::1]:8640")).has_value());
  EXPECT_TRUE(access.CheckHost(RequestTo("evil.example:8640")).has_value());
  EXPECT_TRUE(access.CheckHost(RequestTo("192.168.1.7:8641")).has_value());
}

TEST(Access, UrlsAreThoseThatOthersCanOpen) {
  const ThisMachine robot{.names = {"robot", "robot.local"},
                          .addresses = {"192.168.1.7", "10.0.0.2", "fd00::7"}};
  EXPECT_THAT(
      Access({"0.0.0.0", 8640}, {"0.0.0.0", 8640}, "", robot).Urls(),
      ElementsAre("http://192.168.1.7:8640/", "http://10.0.0.2:8640/", "http://robot:8640/"));
  EXPECT_THAT(Access({"::", 8640}, {"::", 8640}, kToken, {.addresses = {"fd00::7"}}).Urls(),
              ElementsAre("http://[fd00::7]:8640/?token=0123456789abcdef"));
  EXPECT_THAT(Access({"0.0.0.0", 8640}, {"0.0.0.0", 8640}, "").Urls(),
              ElementsAre("http://127.0.0.1:8640/"))
      << "a machine alone";
  EXPECT_THAT(Access({"robot.lan", 8640}, {"192.168.1.7", 8640}, "", robot).Urls(),
              ElementsAre("http://robot.lan:8640/"))
      << "as it was asked for";
}

TEST(Access, EachUrlIsLetIn) {
  const ThisMachine machine = LookUpThisMachine();
  for (const char* everywhere : {"0.0.0.0", "::"}) {
    const Access access({everywhere, 8640}, {everywhere, 8640}, "", machine);
    for (const std::string& url : access.Urls()) {
      const std::string host = url.substr(7, url.size() - 8);
      EXPECT_FALSE(access.CheckHost(RequestTo(host)).has_value()) << host;
    }
  }
}

TEST(ThisMachine, NamesAreThoseThatNoStrangerHas) {
  EXPECT_THAT(NamesOf("Robot"), ElementsAre("robot", "robot.local"));
  EXPECT_THAT(NamesOf("robot.lab.example"),
              ElementsAre("robot.lab.example", "robot", "robot.local"));
  EXPECT_THAT(NamesOf("robot.local"), ElementsAre("robot.local", "robot"));
  for (const char* none : {"", "localhost", "localhost.localdomain", "(none)", "a b", "7", "<x>"}) {
    EXPECT_THAT(NamesOf(none), IsEmpty()) << none;
  }
}

TEST(Access, AnOriginMustBeThePagesOwn) {
  HttpRequest request = RequestTo("localhost:8640", "/socket");
  EXPECT_FALSE(Access::CheckOrigin(request).has_value()) << "a program";
  request.set(http::field::origin, "http://localhost:8640");
  EXPECT_FALSE(Access::CheckOrigin(request).has_value());
  for (const char* origin : {"http://evil.example", "null", "http://localhost", "",
                             "http://localhost:8640.evil.example", "http://127.0.0.1:8640"}) {
    request.set(http::field::origin, origin);
    EXPECT_TRUE(Access::CheckOrigin(request).has_value()) << origin;
  }
}

TEST(Access, WithoutATokenNoneIsAskedFor) {
  EXPECT_FALSE(Loopback().CheckToken(RequestTo("localhost:8640")).has_value());
  EXPECT_THAT(Loopback().Urls(), ElementsAre("http://localhost:8640/"));
}

TEST(Access, WithoutATokenOnlyTheServersUserAndRootAreLetIn) {
  const Access access = Loopback();
  EXPECT_FALSE(access.CheckUser(geteuid()).has_value());
  EXPECT_FALSE(access.CheckUser(0).has_value());
  const std::uint32_t other = geteuid() + 1;
  const auto refusal = access.CheckUser(other);
  ASSERT_TRUE(refusal.has_value());
  EXPECT_EQ(refusal->status, http::status::forbidden);
  EXPECT_EQ(refusal->why,
            "user: is " + std::to_string(other) + ", must be " + std::to_string(geteuid()) +
                " (who runs this cwm-server) or root; others look with a token: start cwm-server "
                "with CWM_VIEWER_TOKEN=TOKEN and open the address that it prints");
  const auto unknown = access.CheckUser(std::nullopt);
  ASSERT_TRUE(unknown.has_value());
  EXPECT_NE(unknown->why.find("user: is not told by the kernel"), std::string::npos);
  EXPECT_FALSE(Loopback(kToken).CheckUser(other).has_value());
  EXPECT_FALSE(Loopback(kToken).CheckUser(std::nullopt).has_value());
}

TEST(Access, ATokenIsTakenFromTheAddressOfThePageOrTheCookieItGives) {
  const Access access = Loopback(kToken);
  EXPECT_THAT(access.Urls(), ElementsAre("http://localhost:8640/?token=0123456789abcdef"));
  const HttpRequest first = RequestTo("localhost:8640", "/?x=1&token=0123456789abcdef");
  EXPECT_FALSE(access.CheckToken(first).has_value());
  EXPECT_EQ(access.CookieFor(first).value(),
            "cwm_viewer_8640=0123456789abcdef; Path=/; HttpOnly; SameSite=Strict");
  HttpRequest next = RequestTo("localhost:8640", "/viewer.js");
  next.set(http::field::cookie, "a=b; cwm_viewer_8640=0123456789abcdef;c=d");
  EXPECT_FALSE(access.CheckToken(next).has_value());
  EXPECT_FALSE(access.CookieFor(next).has_value());
}

TEST(Access, WrongTokensAreRefused) {
  const Access access = Loopback(kToken);
  for (const char* target : {"/", "/?token=", "/?token=0123456789abcdee", "/?token=0123456789abcde",
                             "/?token=0123456789abcdef0", "/?Token=0123456789abcdef",
                             "/viewer.js?token=0123456789abcdef", "/socket"}) {
    const HttpRequest request = RequestTo("localhost:8640", target);
    EXPECT_TRUE(access.CheckToken(request).has_value()) << target;
    EXPECT_FALSE(access.CookieFor(request).has_value()) << target;
  }
  for (const char* cookie : {"cwm_viewer_8640=", "cwm_viewer_8640=0123456789abcdee", ";;;", "=",
                             "cwm_viewer_8641=0123456789abcdef", "cwm_viewer_8640",
                             "xcwm_viewer_8640=0123456789abcdef"}) {
    HttpRequest request = RequestTo("localhost:8640");
    request.set(http::field::cookie, cookie);
    EXPECT_TRUE(access.CheckToken(request).has_value()) << cookie;
  }
}

TEST(Access, TokensHaveARule) {
  EXPECT_TRUE(IsToken(RandomToken()));
  EXPECT_NE(RandomToken(), RandomToken());
  EXPECT_TRUE(IsToken(std::string(128, 'a')));
  EXPECT_FALSE(IsToken(std::string(129, 'a')));
  EXPECT_FALSE(IsToken(std::string(15, 'a')));
  EXPECT_FALSE(IsToken("0123456789abcde;"));
  EXPECT_FALSE(IsToken("0123456789 abcdef"));
}

TEST(ViewerAddress, HostsAndPortsAreRead) {
  EXPECT_EQ(ParseViewerAddress("127.0.0.1:8640")->Text(), "127.0.0.1:8640");
  EXPECT_EQ(ParseViewerAddress("robot.local:0")->Text(), "robot.local:0");
  EXPECT_EQ(ParseViewerAddress("[::1]:65535")->Text(), "[::1]:65535");
  EXPECT_EQ(ParseViewerAddress("[::1]:1")->host, "::1");
  EXPECT_EQ(ParseViewerAddress(kDefaultViewer)->port, 8640);
}

TEST(ViewerAddress, OthersAreRefusedByValueAndRule) {
  for (const char* text :
       {"", "off ", "8640", "127.0.0.1", "127.0.0.1:", "127.0.0.1:65536", ":8640", "127.0.0.1:-1",
        "127.0.0.1:+1", "127.0.0.1: 1", "::1:8640", "[::1]", "[]:1", "[x]:1", "a b:1",
        "http://127.0.0.1:1", "127.0.0.1:1/", "127.0.0.1:99999999999999999999"}) {
    const auto address = ParseViewerAddress(text);
    ASSERT_FALSE(address.ok()) << text;
    EXPECT_NE(
        address.status().message().find("--viewer: is \"" + std::string(text) + "\", must be"),
        std::string::npos)
        << address.status();
  }
}

TEST(ReadableMethods, AreOrdered) {
  const auto methods = ReadableMethods();
  EXPECT_TRUE(std::is_sorted(methods.begin(), methods.end()));
  EXPECT_TRUE(IsReadable("cwm.v1.WorldService/WatchWorld"));
  EXPECT_FALSE(IsReadable("cwm.v1.WorldService/ApplyChanges"));
  EXPECT_FALSE(IsReadable(""));
}

}  // namespace
}  // namespace cwm::server
