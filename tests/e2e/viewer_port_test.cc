// The viewer of the real program: its options, and the cost of crowds and of pages that do not
// read.
#include <sys/resource.h>

#include <chrono>
#include <fstream>
#include <sstream>
#include <thread>

#include "clients/cpp/connection.h"
#include "cwm/v1/viewer.pb.h"
#include "tests/e2e/server_fixture.h"
#include "tests/support/web_client.h"

namespace cwm::testing {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr int kUsage = 1;  // exit codes, see `cwm --help`
constexpr int kUnavailable = 2;

// A port that nobody else can get during its lifetime.
class TakenPort {
 public:
  explicit TakenPort(unsigned short port = 0)
      : acceptor_(context_, {boost::asio::ip::address_v4::loopback(), port}) {}
  std::string address() const {
    return "127.0.0.1:" + std::to_string(acceptor_.local_endpoint().port());
  }

 private:
  boost::asio::io_context context_;
  boost::asio::ip::tcp::acceptor acceptor_;
};

class ViewerPortTest : public ServerTest {
 protected:
  std::string viewer() const override { return "127.0.0.1:0"; }

  std::string WatchRequest() const {
    v1::WatchWorldRequest watch;
    watch.set_mode(v1::WATCH_MODE_COALESCED);
    v1::ViewerRequest request;
    request.set_call_id(1);
    request.mutable_begin()->set_method("cwm.v1.WorldService/WatchWorld");
    request.mutable_begin()->set_request(watch.SerializeAsString());
    return request.SerializeAsString();
  }
  // The revision of the watch's next message; empty if none is received.
  static std::optional<std::int64_t> NextRevision(WebSocketClient& socket,
                                                  milliseconds patience = seconds(20)) {
    const auto bytes = socket.Read(patience);
    v1::ViewerResponse response;
    v1::WatchWorldResponse message;
    if (!bytes || !response.ParseFromString(*bytes) ||
        !message.ParseFromString(response.message())) {
      return std::nullopt;
    }
    return message.revision();
  }
  // Moves every object of the world `times` times, in as many revisions.
  static void MoveAll(const client::Connection& connection, int objects, int from, int times) {
    for (int i = from; i < from + times; ++i) {
      v1::ApplyChangesRequest request;
      for (int k = 0; k < objects; ++k) {
        v1::MoveObject* move = request.add_changes()->mutable_move();
        move->set_name("box_" + std::to_string(k));
        move->mutable_x_world_object()->set_tx_m(k + 1e-4 * (i + 1));
        move->mutable_x_world_object()->set_qw(1);
      }
      v1::ApplyChangesResponse response;
      grpc::ClientContext context;
      ASSERT_TRUE(connection.worlds().ApplyChanges(&context, request, &response).ok());
    }
  }
};

TEST_F(ViewerPortTest, ThePageOfTheBuildIsServed) {
  const int port = ViewerPort();
  ASSERT_GT(port, 0) << ServerLog();
  const HttpResponse page = SendRequest(port, "/");
  EXPECT_EQ(page.status, 200);
  for (const char* file : {"/viewer.js", "/style.css"}) {
    EXPECT_NE(page.body.find(file), std::string::npos) << page.body;
    const HttpResponse answer = SendRequest(port, file);
    EXPECT_EQ(answer.status, 200);
    EXPECT_FALSE(answer.body.empty());
    const HttpResponse zipped = SendRequest(port, file, {{"Accept-Encoding", "gzip"}});
    EXPECT_EQ(zipped.fields.at("content-encoding"), "gzip");
    EXPECT_EQ(zipped.body.substr(0, 2), "\x1f\x8b");
    EXPECT_LT(2 * zipped.body.size(), answer.body.size());
  }
}

TEST_F(ViewerPortTest, AThousandConnectionsThatAskNothingShutNobodyOut) {
  const int port = ViewerPort();
  rlimit files = {};
  ASSERT_EQ(getrlimit(RLIMIT_NOFILE, &files), 0);
  files.rlim_cur = std::min<rlim_t>(files.rlim_max, 4'096);
  ASSERT_EQ(setrlimit(RLIMIT_NOFILE, &files), 0);
  WebSocketClient watching(port);
  ASSERT_TRUE(watching.Send(WatchRequest()));
  const double before_MiB = server().ResidentMebibytes();
  constexpr int kCrowd = 1'000;
  std::vector<std::unique_ptr<RawConnection>> crowd;
  for (int i = 0; i < kCrowd; ++i) crowd.push_back(std::make_unique<RawConnection>(port));
  EXPECT_EQ(SendRequest(port, "/").status, 200);
  EXPECT_EQ(Cwm({"put", "post", "--box", "1,1,1", "--at", "0,0,0"}).exit_code, 0);
  WebSocketClient late(port);
  EXPECT_EQ(late.status(), 101);
  EXPECT_TRUE(late.Send(WatchRequest()));
  EXPECT_EQ(NextRevision(late), 1);
  EXPECT_FALSE(watching.closed());
  constexpr double kMax_MiB = 30;  // a quarter of the crowd, each with a buffer or two
  EXPECT_LT(server().ResidentMebibytes() - before_MiB, kMax_MiB);
}

// The world changes 10 000 times while a page does not read.
TEST_F(ViewerPortTest, APageThatNeverReadsCostsNothingAndIsUpToDateWhenItDoes) {
  constexpr int kObjects = 20;
  constexpr int kChanges = 10'000;
  const client::Connection connection({.address = address(), .deadline = {}});
  for (int k = 0; k < kObjects; ++k) {
    ASSERT_EQ(Cwm({"put", "box_" + std::to_string(k), "--box", "0.1,0.1,0.1", "--at",
                   std::to_string(k) + ",0,0"})
                  .exit_code,
              0);
  }
  // The world's history is filled before anything is measured.
  MoveAll(connection, kObjects, 0, 5'000);
  const int port = ViewerPort();
  WebSocketClient sleeps(port, {.receive_bytes = 16 << 10});
  WebSocketClient reads(port);
  ASSERT_TRUE(sleeps.Send(WatchRequest()));
  ASSERT_TRUE(reads.Send(WatchRequest()));
  ASSERT_TRUE(NextRevision(reads).has_value());
  const double before_MiB = server().ResidentMebibytes();
  MoveAll(connection, kObjects, 5'000, kChanges);
  EXPECT_LT(server().ResidentMebibytes() - before_MiB, 20);
  const std::int64_t last = kObjects + 5'000 + kChanges;
  const auto until_last = [last](WebSocketClient& socket) {
    int messages = 0;
    for (std::int64_t revision = 0; revision < last; ++messages) {
      const auto next = NextRevision(socket);
      if (!next) return -1;
      revision = *next;
    }
    return messages;
  };
  EXPECT_GT(until_last(reads), 0);
  const int messages = until_last(sleeps);
  EXPECT_GT(messages, 0) << "it is told the newest state";
  EXPECT_LT(messages, kChanges / 2) << "and not all that it slept through";
}

class ViewerOptions : public ::testing::Test {
 protected:
  // Starts a server and returns its output until it listens or ends.
  std::string Say(const std::vector<std::string>& arguments, const std::string& token = "") {
    std::vector<std::string> command = {"env", "CWM_VIEWER_TOKEN=" + token, Program("cwm-server"),
                                        "--listen", "unix:" + scratch_ / "cwm.sock"};
    if (token.empty()) command.erase(command.begin() + 1);
    command.insert(command.end(), arguments.begin(), arguments.end());
    const std::string log = scratch_ / "log";
    std::ofstream(log).close();
    server_ = std::make_unique<BackgroundProcess>(command, log);
    for (int i = 0; i < 400 && server_->Running(); ++i) {
      if (RunProgram({Program("cwm"), "--addr", "unix:" + scratch_ / "cwm.sock", "status"})
              .exit_code == 0) {
        break;
      }
      std::this_thread::sleep_for(milliseconds(10));
    }
    // The viewer starts after the services.
    for (int i = 0; i < 100 && server_->Running() && !Said(log, "viewer") && !Said(log, "http://");
         ++i) {
      std::this_thread::sleep_for(milliseconds(10));
    }
    return Text(log);
  }
  static std::string Text(const std::string& path) {
    std::ostringstream text;
    text << std::ifstream(path).rdbuf();
    return text.str();
  }
  static bool Said(const std::string& log, const std::string& words) {
    return Text(log).find(words) != std::string::npos;
  }
  ProcessResult Refused(const std::string& viewer) {
    return RunProgram(
        {Program("cwm-server"), "--listen", "unix:" + scratch_ / "cwm.sock", "--viewer", viewer});
  }

  ScratchDirectory scratch_;
  std::unique_ptr<BackgroundProcess> server_;
};

TEST_F(ViewerOptions, WhatCannotBeAnAddressIsRefusedByTheRule) {
  for (const char* value : {"nonsense", "127.0.0.1", "127.0.0.1:99999", "", ":8640"}) {
    const ProcessResult run = Refused(value);
    EXPECT_EQ(run.exit_code, kUsage) << value;
    EXPECT_NE(run.err.find("--viewer: is \"" + std::string(value) + "\", must be off, HOST:PORT"),
              std::string::npos)
        << run.err;
  }
}

TEST_F(ViewerOptions, AnAddressThatWasAskedForAndIsTakenEndsTheStart) {
  const TakenPort taken;
  const ProcessResult run = Refused(taken.address());
  EXPECT_EQ(run.exit_code, kUnavailable);
  EXPECT_NE(run.err.find("--viewer " + taken.address()), std::string::npos) << run.err;
  const ProcessResult nowhere = Refused("no-such-host.invalid:8640");
  EXPECT_EQ(nowhere.exit_code, kUnavailable);
  EXPECT_NE(nowhere.err.find("no-such-host.invalid"), std::string::npos) << nowhere.err;
}

TEST_F(ViewerOptions, TheDefaultAddressMayBeTaken) {
  std::unique_ptr<TakenPort> taken;
  try {
    taken = std::make_unique<TakenPort>(8640);
  } catch (const std::exception&) {
    // Another program has the port already, which serves as well.
  }
  const std::string said = Say({});
  EXPECT_NE(said.find("--viewer 127.0.0.1:8640"), std::string::npos) << said;
  EXPECT_NE(said.find("going on without a viewer"), std::string::npos) << said;
  EXPECT_EQ(server_->Stop(), 0);
}

TEST_F(ViewerOptions, OffIsOff) {
  const std::string said = Say({"--viewer", "off"});
  EXPECT_EQ(said.find("http"), std::string::npos) << said;
  EXPECT_EQ(server_->Stop(), 0);
}

int PortIn(const std::string& said) {
  const std::size_t end = said.find('/', said.find("//") + 2);
  return std::stoi(said.substr(said.rfind(':', end) + 1));
}

TEST_F(ViewerOptions, BeyondLoopbackTheTokenIsPrintedAndNeeded) {
  const std::string said = Say({"--viewer", "0.0.0.0:0"});
  const std::size_t token = said.find("/?token=");
  ASSERT_NE(token, std::string::npos) << said;
  EXPECT_EQ(said.find("http://0.0.0.0"), std::string::npos) << said;
  const int port = PortIn(said);
  EXPECT_EQ(SendRequest(port, "/").status, 403);
  // Each printed address is admitted, and a stranger's name is not.
  int printed = 0;
  for (std::size_t at = 0; (at = said.find("http://", at)) != std::string::npos; ++printed) {
    at += 7;
    const std::size_t path = said.find('/', at);
    const std::string host = said.substr(at, path - at);
    EXPECT_EQ(
        SendRequest(port, said.substr(path, said.find('\n', path) - path), {{"Host", host}}).status,
        200)
        << host;
  }
  EXPECT_GT(printed, 0);
  const std::string evil = "evil.example:" + std::to_string(port);
  EXPECT_NE(SendRequest(port, "/", {{"Host", evil}}).body.find("Host: is \"" + evil),
            std::string::npos);
  EXPECT_EQ(SendRequest(port, said.substr(token, said.find('\n', token) - token)).status, 200);
  EXPECT_EQ(WebSocketClient(port).status(), 403);
  EXPECT_EQ(server_->Stop(), 0);
}

TEST_F(ViewerOptions, AUserMayChooseTheToken) {
  const std::string said = Say({"--viewer", "127.0.0.1:0"}, "chosen-by-the-user");
  EXPECT_NE(said.find("/?token=chosen-by-the-user\n"), std::string::npos) << said;
  EXPECT_EQ(SendRequest(PortIn(said), "/").status, 403) << "on loopback too";
  EXPECT_EQ(SendRequest(PortIn(said), "/?token=chosen-by-the-user").status, 200);
  EXPECT_EQ(server_->Stop(), 0);
  const std::string weak = Say({"--viewer", "127.0.0.1:0"}, "short");
  EXPECT_NE(weak.find("CWM_VIEWER_TOKEN: has 5 characters, must be 16 to 128"), std::string::npos)
      << weak;
  EXPECT_FALSE(server_->Running());
}

}  // namespace
}  // namespace cwm::testing
