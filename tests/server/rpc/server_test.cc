#include "server/rpc/server.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <memory>
#include <semaphore>
#include <thread>
#include <utility>

#include "server/rpc/listen_address.h"
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
  // The grace exceeds the test's time limit: draining returns without using it up.
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

// Holds a world's writer's turn during its lifetime.
class HeldTurn {
 public:
  explicit HeldTurn(std::shared_ptr<World> world)
      : holder_([this, world] {
          const auto outcome = world->Update(
              [this](const SnapshotPtr&) {
                taken_.release();
                released_.acquire();
                return std::vector<collision::Change>{};
              },
              {});
          EXPECT_TRUE(outcome.ok()) << outcome.status();
        }) {
    taken_.acquire();
  }
  ~HeldTurn() { released_.release(); }

 private:
  std::binary_semaphore taken_{0};
  std::binary_semaphore released_{0};
  std::jthread holder_;  // last: ends before the semaphores
};

TEST_F(ServerTest, AFullQueueOfWritesSaysWhenToComeBackAndReadsGoOn) {
  PutBox("a", 0);
  constexpr int kMax = 1'000;  // more than the queue and its threads can hold
  std::vector<std::jthread> writers;
  std::atomic<int> refused = 0;
  std::atomic<int> written = 0;
  {
    const HeldTurn turn(*application_.worlds.Find(""));
    for (int i = 0; i < kMax && refused == 0; ++i) {
      writers.emplace_back([&] {
        Call call;
        v1::ApplyChangesRequest request;
        *request.add_changes() = PutBoxChange("b", 1);
        v1::ApplyChangesResponse response;
        const grpc::Status status = world_->ApplyChanges(&call, request, &response);
        if (status.ok()) {
          ++written;
          return;
        }
        EXPECT_EQ(status.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
        EXPECT_EQ(ReasonIn(status), "QUEUE_FULL");
        EXPECT_TRUE(DetailsIn(status).has_retry);
        ++refused;
      });
      ExpectRevision(1);  // a read meanwhile
    }
    EXPECT_GT(refused, 0);
    EXPECT_EQ(written, 0);
  }
  writers.clear();  // joins
  EXPECT_GT(written, 0) << "what had a place is done";
  ExpectRevision(2);
}

TEST_F(ServerTest, AThousandStreamsAreOpenAtOnceAndNotOneMore) {
  PutBox("a", 0);
  struct Stream {
    Call call{std::chrono::minutes(5)};
    std::unique_ptr<grpc::ClientReaderWriter<v1::StreamQueriesRequest, v1::StreamQueriesResponse>>
        wire;
  };
  v1::StreamQueriesRequest request;
  *request.mutable_get_distances()->mutable_subject() = SphereAt({0.5});
  v1::StreamQueriesResponse response;
  std::vector<std::unique_ptr<Stream>> streams;
  for (int i = 0; i < 1'000; ++i) {
    streams.push_back(std::make_unique<Stream>());
    streams.back()->wire = query_->StreamQueries(&streams.back()->call);
    ASSERT_TRUE(streams.back()->wire->Write(request));
    ASSERT_TRUE(streams.back()->wire->Read(&response)) << "stream " << i;
  }
  {
    Call call;
    const auto one_more = query_->StreamQueries(&call);
    EXPECT_FALSE(one_more->Read(&response));
    const grpc::Status status = one_more->Finish();
    EXPECT_EQ(status.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
    EXPECT_EQ(ReasonIn(status), "TOO_MANY_STREAMS");
    EXPECT_TRUE(DetailsIn(status).has_retry);
  }
  for (const auto& stream : streams) {
    request.set_id(request.id() + 1);
    ASSERT_TRUE(stream->wire->Write(request) && stream->wire->Read(&response));
    EXPECT_EQ(response.id(), request.id());
    stream->wire->WritesDone();
    EXPECT_TRUE(stream->wire->Finish().ok());
  }
}

TEST_F(ServerTest, AServerThatStopsLeavesTheSocketOfItsSuccessor) {
  // A cloud being interpreted keeps the first server in its grace period.
  std::binary_semaphore begun{0};
  std::binary_semaphore finish{0};
  application_.interpret = [&](const auto&, const auto&, std::stop_token) {
    begun.release();
    finish.acquire();
    return absl::StatusOr<perception::SceneInterpretation>(absl::CancelledError("over"));
  };
  Call ingest;
  v1::IngestCloudResponse ignored;
  const auto writer = SendOnePoint(&ingest, &ignored);
  begun.acquire();
  std::jthread stopper([this] { server_->Stop(std::chrono::hours(1)); });
  Application next{.limits = {}, .retention = {}, .interpret = {}};
  absl::StatusOr<std::unique_ptr<Server>> successor = absl::UnknownError("");
  for (int i = 0; i < 1'000 && !successor.ok(); ++i) {  // until the first no longer listens
    successor = Server::Start(next, {.addresses = {address_}});
    if (!successor.ok()) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  ASSERT_TRUE(successor.ok()) << successor.status();
  finish.release();
  stopper.join();
  EXPECT_TRUE(FindSocket(address_).has_value());
  const auto admin =
      v1::AdminService::NewStub(grpc::CreateChannel(address_, grpc::InsecureChannelCredentials()));
  Call call;
  v1::GetServerInfoResponse info;
  EXPECT_TRUE(admin->GetServerInfo(&call, {}, &info).ok());
}

// In each round the drain meets the streams in another state: reading, queued, answering, writing.
TEST(DrainingTest, BusyStreamsEndOnceWhereverTheDrainMeetsThem) {
  constexpr int kRounds = 40;
  constexpr int kStreams = 8;
  for (int round = 0; round < kRounds; ++round) {
    const testing::ScratchDirectory scratch;
    Application application{.limits = {}, .retention = {}, .interpret = {}};
    const std::string address = "unix:" + (scratch / "cwm.sock");
    auto server = Server::Start(application, {.addresses = {address}});
    ASSERT_TRUE(server.ok()) << server.status();
    ASSERT_TRUE(application.worlds.FindOrCreate("").ok());
    const auto stub =
        v1::QueryService::NewStub(grpc::CreateChannel(address, grpc::InsecureChannelCredentials()));
    std::atomic<int> begun = 0;
    std::vector<grpc::Status> ends(kStreams);
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
          ends[i] = stream->Finish();
        });
      }
      while (begun < kStreams) std::this_thread::yield();
      std::this_thread::sleep_for(std::chrono::microseconds(100 * round));
      (*server)->Stop(std::chrono::minutes(1));
    }
    // The code of a drained stream and of a connection that closed before its end was read.
    for (const grpc::Status& end : ends) {
      EXPECT_EQ(end.error_code(), grpc::StatusCode::UNAVAILABLE) << end.error_message();
    }
  }
}

}  // namespace
}  // namespace cwm::server
