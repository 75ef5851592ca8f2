#include "server/rpc/accept_loop.h"

#include <gmock/gmock.h>
#include <grpcpp/server_posix.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <chrono>
#include <mutex>
#include <set>
#include <thread>
#include <utility>

#include "server/rpc/listener.h"
#include "server/rpc/self_check.h"
#include "tests/server/rpc/running_server.h"
#include "tests/support/raw_peer.h"

namespace cwm::server {
namespace {

using std::chrono::milliseconds;
using testing::Http2ClientPreface;
using testing::Http2Frame;
using testing::RawPeer;

constexpr auto kSilence = milliseconds(300);
constexpr auto kSoon = std::chrono::seconds(10);

TransportLimits FewConnections() {
  TransportLimits limits;
  limits.max_silence = kSilence;
  limits.max_connections = 16;
  limits.max_connections_of_user = 8;
  limits.max_silent_connections = 4;
  return limits;
}

class AcceptLoopTest : public RunningServer {
 protected:
  AcceptLoopTest() : RunningServer(Limits{}, Retention{}, FewConnections()) {}

  // The fixture's channel connects with its first call.
  void ExpectOneConnection() { EXPECT_EQ(Stats(*admin_).connections_open(), 1); }

  static v1::GetStatsResponse Stats(v1::AdminService::Stub& admin) {
    Call call;
    v1::GetStatsResponse stats;
    const grpc::Status status = admin.GetStats(&call, {}, &stats);
    EXPECT_TRUE(status.ok()) << status.error_message();
    return stats;
  }
};

TEST_F(AcceptLoopTest, WhatSaysNothingIsClosedAndWhatSpeaksStays) {
  const RawPeer silent(address_);
  const RawPeer half(address_);
  const RawPeer speaks(address_);
  ASSERT_TRUE(half.Send(Http2ClientPreface().substr(0, 32)));
  ASSERT_TRUE(speaks.Send(Http2ClientPreface()));
  const auto begun = Clock::now();
  EXPECT_TRUE(silent.IsClosedWithin(kSoon));
  EXPECT_TRUE(half.IsClosedWithin(kSoon));
  EXPECT_GT(Clock::now() - begun, kSilence / 2);
  EXPECT_FALSE(speaks.IsClosedWithin(2 * kSilence));
  EXPECT_EQ(Stats(*admin_).connections_shed(), 2);
}

TEST_F(AcceptLoopTest, WhatIsNoHttp2IsClosedAtOnce) {
  // The last cases: a stream begun before the settings, another frame of the connection, a wrong
  // byte after right ones.
  const std::string preface = Http2ClientPreface().substr(0, 24);
  for (const std::string& garbage :
       {std::string("GET / HTTP/1.1\r\n\r\n"), std::string("\x16\x03\x01", 3), std::string("X"),
        preface + Http2Frame(1, 4, 1, ""), preface + Http2Frame(4, 0, 1, ""),
        preface + Http2Frame(8, 0, 0, "abcd"), preface.substr(0, 20) + "XXXX"}) {
    const RawPeer peer(address_);
    const auto begun = Clock::now();
    ASSERT_TRUE(peer.Send(garbage));
    EXPECT_TRUE(peer.IsClosedWithin(kSoon)) << garbage;
    EXPECT_LT(Clock::now() - begun, kSilence) << garbage;
  }
  EXPECT_EQ(PutBox("a", 0), 1);
}

TEST_F(AcceptLoopTest, WhatComesByteByByteIsServed) {
  const RawPeer peer(address_);
  for (const char byte : Http2ClientPreface()) {
    ASSERT_TRUE(peer.Send(std::string(1, byte)));
    std::this_thread::sleep_for(milliseconds(1));
  }
  EXPECT_EQ(peer.Receive(9, kSoon).size(), 9U) << "the settings of the server";
}

TEST_F(AcceptLoopTest, AUserHasSoManyConnectionsAndTheNextOnesAreClosedAtOnce) {
  ExpectOneConnection();
  std::vector<RawPeer> peers;
  for (int i = 0; i < 7; ++i) {
    peers.emplace_back(address_);
    ASSERT_TRUE(peers.back().Send(Http2ClientPreface()));
    ASSERT_EQ(peers.back().Receive(9, kSoon).size(), 9U) << i;
  }
  for (int i = 0; i < 20; ++i) {
    const RawPeer one_more(address_);
    EXPECT_TRUE(one_more.IsClosedWithin(kSoon));
  }
  const auto stats = Stats(*admin_);
  EXPECT_EQ(stats.connections_open(), 8);
  EXPECT_EQ(stats.connections_shed(), 20);
  peers.clear();
  const auto stub =
      v1::AdminService::NewStub(grpc::CreateChannel(address_, grpc::InsecureChannelCredentials()));
  Call call;
  call.set_wait_for_ready(true);
  v1::GetServerInfoResponse info;
  EXPECT_TRUE(stub->GetServerInfo(&call, {}, &info).ok()) << "there is room again";
}

TEST_F(AcceptLoopTest, TheLongestSilentOfAUserMakesRoomForTheNext) {
  ExpectOneConnection();
  std::vector<RawPeer> silent;
  for (int i = 0; i < 6; ++i) {
    silent.emplace_back(address_);
    std::this_thread::sleep_for(milliseconds(5));
  }
  EXPECT_TRUE(silent[0].IsClosedWithin(kSilence / 3));
  EXPECT_TRUE(silent[1].IsClosedWithin(kSilence / 3));
  ASSERT_TRUE(silent[5].Send(Http2ClientPreface()));
  EXPECT_EQ(silent[5].Receive(9, kSoon).size(), 9U);
}

TEST_F(AcceptLoopTest, AThousandThatComeAndGoLeaveNothing) {
  for (int i = 0; i < 1'000; ++i) {
    const RawPeer peer(address_);
    if (i % 2 == 0) peer.Send(Http2ClientPreface().substr(0, static_cast<std::size_t>(i) % 34));
  }
  for (int i = 0; i < 100 && Stats(*admin_).connections_open() > 1; ++i) {
    std::this_thread::sleep_for(milliseconds(50));
  }
  EXPECT_EQ(Stats(*admin_).connections_open(), 1);
}

TEST_F(AcceptLoopTest, TheServerLooksAtItselfThoughNobodyElseIsAdmitted) {
  ExpectOneConnection();
  std::vector<RawPeer> peers;
  for (int i = 0; i < 7; ++i) {
    peers.emplace_back(address_);
    ASSERT_TRUE(peers.back().Send(Http2ClientPreface()));
    ASSERT_EQ(peers.back().Receive(9, kSoon).size(), 9U);
  }
  EXPECT_FALSE(CheckHealth(address_, kSoon).ok()) << "a stranger is not admitted";
  for (int i = 0; i < 3; ++i) {
    const absl::Status status = server_->CheckItself(kSoon);
    EXPECT_TRUE(status.ok()) << status;
  }
}

// A test server that records who calls it.
class WhoCalls final : public v1::AdminService::CallbackService {
 public:
  explicit WhoCalls(const Runtime& runtime) : runtime_(runtime) {}
  grpc::ServerUnaryReactor* GetServerInfo(grpc::CallbackServerContext* context,
                                          const v1::GetServerInfoRequest*,
                                          v1::GetServerInfoResponse*) override {
    {
      const std::lock_guard lock(mutex_);
      last_ = runtime_.ClientOf(*context);
    }
    grpc::ServerUnaryReactor* const reactor = context->DefaultReactor();
    reactor->Finish(grpc::Status::OK);
    return reactor;
  }
  ClientId last() {
    const std::lock_guard lock(mutex_);
    return last_;
  }

 private:
  const Runtime& runtime_;
  std::mutex mutex_;
  ClientId last_ = {.connection = -7, .uid = {}};
};

class ClientOfTest : public ::testing::TestWithParam<const char*> {
 protected:
  ClientOfTest() {
    grpc::ServerBuilder builder;
    builder.RegisterService(&who_);
    server_ = builder.BuildAndStart();
    const std::string address = GetParam();
    auto listener = Listen(address == "unix" ? "unix:" + (scratch_ / "s") : address, kSoon);
    EXPECT_TRUE(listener.ok()) << listener.status();
    address_ = listener->address;
    auto loop = AcceptLoop::Start(
        std::move(listener->sockets), runtime_.connections, kSoon,
        [this](int descriptor) { grpc::AddInsecureChannelFromFd(server_.get(), descriptor); });
    EXPECT_TRUE(loop.ok()) << loop.status();
    loop_ = *std::move(loop);
  }
  ~ClientOfTest() override {
    loop_ = nullptr;
    server_->Shutdown(std::chrono::system_clock::now());
  }

  std::shared_ptr<grpc::Channel> Dial() const {
    grpc::ChannelArguments arguments;
    arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
    return grpc::CreateCustomChannel(address_, grpc::InsecureChannelCredentials(), arguments);
  }
  ClientId ClientIdOf(const std::shared_ptr<grpc::Channel>& channel) {
    Call call;
    v1::GetServerInfoResponse info;
    const auto status = v1::AdminService::NewStub(channel)->GetServerInfo(&call, {}, &info);
    EXPECT_TRUE(status.ok()) << status.error_message();
    return who_.last();
  }

  testing::ScratchDirectory scratch_;
  Application application_{.limits = {}, .retention = {}, .interpret = {}};
  Runtime runtime_{application_};
  WhoCalls who_{runtime_};
  std::unique_ptr<grpc::Server> server_;
  std::unique_ptr<AcceptLoop> loop_;
  std::string address_;
};

INSTANTIATE_TEST_SUITE_P(Addresses, ClientOfTest,
                         ::testing::Values("unix", "127.0.0.1:0", "localhost:0"));

TEST_P(ClientOfTest, EachConnectionIsAnotherClientHoweverManyCameBefore) {
  const auto first = Dial();
  const ClientId id = ClientIdOf(first);
  EXPECT_EQ(id.connection, 1);
  std::set<std::int64_t> seen = {id.connection};
  for (int i = 0; i < 300; ++i) {
    const auto channel = Dial();
    const ClientId other = ClientIdOf(channel);
    EXPECT_TRUE(seen.insert(other.connection).second) << other.connection << " came twice";
    EXPECT_EQ(ClientIdOf(channel), other);
  }
  EXPECT_EQ(ClientIdOf(first), id) << "it stays who it is";
}

TEST_P(ClientOfTest, TheUserIsTheOneWhoConnected) {
  const ClientId id = ClientIdOf(Dial());
  EXPECT_GT(id.connection, 0);
  EXPECT_EQ(id.uid, ClientId{.uid = getuid()}.uid);
}

TEST_P(ClientOfTest, ACallWithinTheProcessIsNobodys) {
  EXPECT_EQ(ClientIdOf(server_->InProcessChannel({})), ClientId{});
}

// Limits the process to `more` further descriptors during its lifetime.
class FewDescriptors {
 public:
  explicit FewDescriptors(int more) {
    getrlimit(RLIMIT_NOFILE, &before_);
    rlimit limit = before_;
    const rlim_t next = static_cast<rlim_t>(FileDescriptor(dup(0)).number());
    limit.rlim_cur = next + static_cast<rlim_t>(more);
    setrlimit(RLIMIT_NOFILE, &limit);
  }
  ~FewDescriptors() { setrlimit(RLIMIT_NOFILE, &before_); }
  FewDescriptors(const FewDescriptors&) = delete;
  FewDescriptors& operator=(const FewDescriptors&) = delete;

 private:
  rlimit before_{};
};

TEST(FullTableTest, WithoutADescriptorConnectionsAreClosedAndLaterOnesAreTaken) {
  const testing::ScratchDirectory scratch;
  const std::string path = scratch / "s";
  auto listener = Listen("unix:" + path, kSoon);
  ASSERT_TRUE(listener.ok());
  Connections connections({.all = 1'000, .of_user = 1'000, .silent_of_user = 1'000}, 1'024);
  std::mutex mutex;
  std::vector<FileDescriptor> taken;
  const auto count = [&] {
    const std::lock_guard lock(mutex);
    return taken.size();
  };
  const auto loop =
      AcceptLoop::Start(std::move(listener->sockets), connections, kSoon, [&](int descriptor) {
        const std::lock_guard lock(mutex);
        taken.emplace_back(descriptor);
      });
  ASSERT_TRUE(loop.ok());
  constexpr int kCrowd = 40;
  constexpr int kLater = 3;
  std::vector<FileDescriptor> peers;
  for (int i = 0; i < kCrowd + kLater; ++i) {
    peers.emplace_back(socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0));
  }
  const auto speak = [&](const FileDescriptor& peer) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path.copy(address.sun_path, sizeof(address.sun_path) - 1);
    EXPECT_EQ(connect(peer.number(), reinterpret_cast<sockaddr*>(&address), sizeof(address)), 0);
    send(peer.number(), Http2ClientPreface().data(), Http2ClientPreface().size(), MSG_NOSIGNAL);
  };
  constexpr int kFree = 6;
  const FewDescriptors few(kFree);
  for (int i = 0; i < kCrowd; ++i) speak(peers[static_cast<std::size_t>(i)]);
  const auto until = Clock::now() + kSoon;
  while (connections.shed() < kCrowd - kFree && Clock::now() < until) {
    std::this_thread::sleep_for(milliseconds(10));
  }
  EXPECT_GE(connections.shed(), kCrowd - kFree) << "who comes in vain hears so";
  EXPECT_LE(count(), static_cast<std::size_t>(kFree));
  {
    const std::lock_guard lock(mutex);
    taken.clear();
  }
  for (int i = kCrowd; i < kCrowd + kLater; ++i) speak(peers[static_cast<std::size_t>(i)]);
  while (count() < kLater && Clock::now() < until) std::this_thread::sleep_for(milliseconds(10));
  EXPECT_EQ(count(), static_cast<std::size_t>(kLater));
}

TEST(ListenTest, LocalhostIsBothLoopbackAddressesOnOnePort) {
  const auto listener = Listen("localhost:0", kSoon);
  ASSERT_TRUE(listener.ok()) << listener.status();
  EXPECT_GE(listener->sockets.size(), 1U);
  EXPECT_LE(listener->sockets.size(), 2U);
  const std::string port = listener->address.substr(listener->address.rfind(':') + 1);
  EXPECT_NE(port, "0");
  EXPECT_TRUE(RawPeer("127.0.0.1:" + port).is_connected());
}

TEST(ListenTest, APortThatIsTakenIsRefusedWithTheReason) {
  const auto first = Listen("127.0.0.1:0", kSoon);
  ASSERT_TRUE(first.ok());
  const std::string port = first->address.substr(first->address.rfind(':') + 1);
  for (const std::string& address : {first->address, "localhost:" + port}) {
    const auto second = Listen(address, kSoon);
    EXPECT_EQ(second.status().message(),
              "--listen " + address + ": cannot listen: Address already in use");
  }
  EXPECT_THAT(std::string(Listen("unix:/nowhere/at/all/s", kSoon).status().message()),
              ::testing::HasSubstr("No such file or directory"));
}

}  // namespace
}  // namespace cwm::server
