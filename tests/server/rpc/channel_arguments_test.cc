// The server's limits also apply to connections that gRPC did not accept itself.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <map>
#include <string>

#include "tests/server/rpc/running_server.h"
#include "tests/support/raw_peer.h"

namespace cwm::server {
namespace {

using ::testing::HasSubstr;
using testing::Http2ClientPreface;
using testing::RawPeer;

constexpr auto kSoon = std::chrono::seconds(10);
constexpr auto kKeepalive = std::chrono::milliseconds(300);

TransportLimits ImpatientLimits() {
  TransportLimits limits;
  limits.keepalive_time = kKeepalive;
  limits.keepalive_timeout = kKeepalive;
  return limits;
}

class ChannelArgumentsTest : public RunningServer {
 protected:
  ChannelArgumentsTest() : RunningServer(Limits{}, Retention{}, ImpatientLimits()) {}
};

std::uint32_t NumberIn(const std::string& bytes, std::size_t at, std::size_t size) {
  std::uint32_t number = 0;
  for (std::size_t i = 0; i < size; ++i) {
    number = number << 8 | static_cast<unsigned char>(bytes.at(at + i));
  }
  return number;
}

TEST_F(ChannelArgumentsTest, TheSettingsTellTheLimitsOfTheServer) {
  const RawPeer peer(address_);
  ASSERT_TRUE(peer.Send(Http2ClientPreface()));
  const std::string header = peer.Receive(9, kSoon);
  ASSERT_EQ(header.size(), 9U);
  ASSERT_EQ(header[3], 4) << "a SETTINGS frame comes first";
  const std::string settings = peer.Receive(NumberIn(header, 0, 3), kSoon);
  std::map<std::uint32_t, std::uint32_t> values;
  for (std::size_t i = 0; i + 6 <= settings.size(); i += 6) {
    values[NumberIn(settings, i, 2)] = NumberIn(settings, i + 2, 4);
  }
  constexpr std::uint32_t kMaxConcurrentStreams = 3;
  constexpr std::uint32_t kMaxHeaderListSize = 6;
  v1::GetServerInfoResponse info;
  Call call;
  ASSERT_TRUE(admin_->GetServerInfo(&call, {}, &info).ok());
  EXPECT_EQ(values[kMaxConcurrentStreams], info.limits().max_calls_of_connection());
  EXPECT_GT(info.limits().max_calls_of_connection(),
            info.limits().max_streams() + info.limits().max_watchers());
  EXPECT_EQ(values[kMaxHeaderListSize], info.limits().max_metadata_bytes());
}

TEST_F(ChannelArgumentsTest, MetadataOverTheLimitIsRefusedAndTheServerGoesOn) {
  for (const std::size_t size : {std::size_t{15} << 10, std::size_t{40} << 10}) {
    Call call;
    call.AddMetadata("x-long", std::string(size, 'a'));
    v1::GetServerInfoResponse info;
    const auto code = admin_->GetServerInfo(&call, {}, &info).error_code();
    EXPECT_EQ(code, size < std::size_t{16} << 10 ? grpc::StatusCode::OK
                                                 : grpc::StatusCode::RESOURCE_EXHAUSTED);
  }
  // gRPC closes the connection that brought too much. A call that is under way then fails, and the
  // next one opens another connection.
  bool answers = false;
  for (int attempt = 0; attempt < 3 && !answers; ++attempt) {
    Call call;
    v1::GetServerInfoResponse info;
    answers = admin_->GetServerInfo(&call, {}, &info).ok();
  }
  EXPECT_TRUE(answers);
  EXPECT_EQ(PutBox("a", 0), 1);
}

TEST_F(ChannelArgumentsTest, CompressedCallsAreRefusedAndNeverInflated) {
  v1::ApplyChangesRequest request;
  request.set_world(std::string(std::size_t{8} << 20, 'a'));  // 8 kB compressed
  for (const auto algorithm : {GRPC_COMPRESS_DEFLATE, GRPC_COMPRESS_GZIP}) {
    Call call;
    call.set_compression_algorithm(algorithm);
    v1::ApplyChangesResponse response;
    const grpc::Status status = world_->ApplyChanges(&call, request, &response);
    EXPECT_EQ(status.error_code(), grpc::StatusCode::UNIMPLEMENTED) << status.error_message();
    EXPECT_THAT(status.error_message(), HasSubstr("Compression"));
  }
  EXPECT_EQ(application_.memory->client_bytes(), 0);
  EXPECT_EQ(PutBox("a", 0), 1);
}

TEST_F(ChannelArgumentsTest, APeerThatAnswersNoPingIsClosed) {
  const RawPeer peer(address_);
  ASSERT_TRUE(peer.Send(Http2ClientPreface()));
  const auto begun = Clock::now();
  EXPECT_TRUE(peer.IsClosedWithin(kSoon));
  EXPECT_GE(Clock::now() - begun, kKeepalive);
}

TEST_F(ChannelArgumentsTest, APeerThatAnswersPingsStays) {
  const RawPeer peer(address_);
  ASSERT_TRUE(peer.Send(Http2ClientPreface()));
  const auto until = Clock::now() + 10 * kKeepalive;
  int pings = 0;
  while (Clock::now() < until) {
    const std::string header = peer.Receive(9, kKeepalive);
    if (header.size() < 9) continue;
    const std::string payload = peer.Receive(NumberIn(header, 0, 3), kSoon);
    constexpr int kPing = 6;
    constexpr int kAcknowledged = 1;
    if (header[3] != kPing || header[4] == kAcknowledged) continue;
    ++pings;
    ASSERT_TRUE(peer.Send(testing::Http2Frame(kPing, kAcknowledged, 0, payload)));
  }
  EXPECT_GE(pings, 2) << "gRPC sends one a second at most";
  EXPECT_FALSE(peer.IsClosedWithin(kKeepalive / 2));
}

}  // namespace
}  // namespace cwm::server
