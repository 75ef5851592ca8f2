#include "server/rpc/server.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <thread>
#include <utility>

#include "tests/server/rpc/running_server.h"

namespace cwm::server {
namespace {

class ServerTest : public RunningServer {};

TEST_F(ServerTest, TellsItsVersionLimitsAndEngines) {
  Call call;
  v1::GetServerInfoResponse info;
  ASSERT_TRUE(admin_->GetServerInfo(&call, {}, &info).ok());
  EXPECT_FALSE(info.version().empty());
  EXPECT_EQ(info.limits().max_cloud_points(), 20'000'000);
  EXPECT_EQ(info.limits().max_message_bytes(), 16 << 20);
  EXPECT_EQ(info.retention().watch_seconds(), 300);
  ASSERT_EQ(info.engines_size(), 3);
  EXPECT_EQ(info.engines(1).name(), "FCL");
  for (const v1::EngineInfo& engine : info.engines()) EXPECT_FALSE(engine.version().empty());
  EXPECT_EQ(info.store(), "memory");
}

TEST_F(ServerTest, AMessageOverTheLimitIsRefusedAndTheServerGoesOn) {
  v1::GetDistancesRequest request;
  request.mutable_subject()->mutable_points()->mutable_data()->resize(17 << 20);
  v1::GetDistancesResponse response;
  {
    Call call;
    EXPECT_EQ(query_->GetDistances(&call, request, &response).error_code(),
              grpc::StatusCode::RESOURCE_EXHAUSTED);
  }
  EXPECT_EQ(PutBox("a", 0), 1);
}

TEST_F(ServerTest, DrainingEndsWatchesAndStreamsAndRefusesWhatComes) {
  PutBox("a", 0);
  Call watch_call;
  const auto watch = world_->WatchWorld(&watch_call, {});
  v1::WatchWorldResponse message;
  ASSERT_TRUE(watch->Read(&message));
  Call stream_call;
  const auto stream = query_->StreamQueries(&stream_call);
  v1::StreamQueriesRequest request;
  *request.mutable_get_distances()->mutable_subject() = SphereAt({0.5});
  v1::StreamQueriesResponse response;
  ASSERT_TRUE(stream->Write(request) && stream->Read(&response));
  // A grace beyond the test's own time limit: what drains returns without using it up.
  std::jthread stopper([this] { server_->Stop(std::chrono::hours(1)); });
  ASSERT_TRUE(watch->Read(&message));
  EXPECT_TRUE(message.has_bookmark());
  EXPECT_EQ(message.revision(), 1);
  EXPECT_FALSE(watch->Read(&message));
  EXPECT_EQ(ReasonIn(watch->Finish()), "SERVER_DRAINING");
  EXPECT_FALSE(stream->Read(&response));
  EXPECT_EQ(ReasonIn(stream->Finish()), "SERVER_DRAINING");
  stopper.join();
  Call late;
  v1::GetServerInfoResponse info;
  EXPECT_EQ(admin_->GetServerInfo(&late, {}, &info).error_code(), grpc::StatusCode::UNAVAILABLE);
}

// Every round meets the streams somewhere else: reading, queued, answering, writing.
TEST(DrainingTest, BusyStreamsEndOnceWhereverTheDrainMeetsThem) {
  constexpr int kRounds = 40;
  constexpr int kStreams = 8;
  for (int round = 0; round < kRounds; ++round) {
    const testing::ScratchDirectory scratch;
    Application application{.limits = {}, .retention = {}, .interpret = {}};
    const std::string address = "unix:" + (scratch / "cwm.sock");
    auto server = Server::Start(application, {address});
    ASSERT_TRUE(server.ok()) << server.status();
    ASSERT_TRUE(application.worlds.FindOrCreate("").ok());
    const auto stub =
        v1::QueryService::NewStub(grpc::CreateChannel(address, grpc::InsecureChannelCredentials()));
    std::atomic<int> begun = 0;
    std::vector<std::string> reasons(kStreams);
    {
      std::vector<std::jthread> clients;
      for (int i = 0; i < kStreams; ++i) {
        clients.emplace_back([&, i] {
          Call call;
          const auto stream = stub->StreamQueries(&call);
          v1::StreamQueriesRequest request;
          *request.mutable_get_distances()->mutable_subject() = SphereAt({0.5});
          v1::StreamQueriesResponse response;
          bool first = true;
          while (stream->Write(request) && stream->Read(&response)) {
            if (std::exchange(first, false)) ++begun;
          }
          reasons[i] = ReasonIn(stream->Finish());
        });
      }
      while (begun < kStreams) std::this_thread::yield();
      std::this_thread::sleep_for(std::chrono::microseconds(100 * round));
      (*server)->Stop(std::chrono::minutes(1));
    }
    for (const std::string& reason : reasons) EXPECT_EQ(reason, "SERVER_DRAINING");
  }
}

}  // namespace
}  // namespace cwm::server
