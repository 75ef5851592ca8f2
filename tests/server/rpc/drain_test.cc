// The end of calls when the server stops.
#include <gmock/gmock.h>
#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <memory>
#include <semaphore>
#include <string>
#include <thread>
#include <vector>

#include "tests/server/rpc/running_server.h"

namespace cwm::server {
namespace {

using std::chrono::milliseconds;

// The target for a server whose clients have no calls in progress.
constexpr auto kSoon = std::chrono::seconds(1);
constexpr auto kLong = std::chrono::minutes(1);

class DrainTest : public RunningServer {
 protected:
  std::shared_ptr<grpc::Channel> DialAlone() const {
    grpc::ChannelArguments arguments;
    arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
    arguments.SetMaxReceiveMessageSize(-1);
    return grpc::CreateCustomChannel(address_, grpc::InsecureChannelCredentials(), arguments);
  }
  Clock::duration TimeOfStop(milliseconds grace) {
    const auto begun = Clock::now();
    server_->Stop(grace);
    return Clock::now() - begun;
  }
};

void ExpectDraining(const grpc::Status& status) {
  EXPECT_EQ(status.error_code(), grpc::StatusCode::UNAVAILABLE) << status.error_message();
  EXPECT_EQ(ReasonIn(status), "SERVER_DRAINING");
  EXPECT_TRUE(DetailsIn(status).has_retry);
}

TEST_F(DrainTest, IdleConnectionsDoNotHoldItUp) {
  std::vector<std::shared_ptr<grpc::Channel>> idle;
  for (int i = 0; i < 100; ++i) {
    idle.push_back(DialAlone());
    Call call;
    v1::GetServerInfoResponse info;
    ASSERT_TRUE(v1::AdminService::NewStub(idle.back())->GetServerInfo(&call, {}, &info).ok());
  }
  EXPECT_LT(TimeOfStop(kLong), kSoon);
}

// A client's thread may rest for as long between the start of a call and its first byte.
constexpr milliseconds kMinHeadStart{30};

// Results of the calls that clients made while the server stopped.
struct Outcomes {
  std::atomic<int> answered = 0;
  std::atomic<int> draining_errors = 0;      // refused with SERVER_DRAINING and the time to retry
  std::atomic<int> closed = 0;               // UNAVAILABLE from the transport
  std::atomic<int> closed_though_early = 0;  // the same for a call that began well before the stop
  std::atomic<int> other = 0;
};

void CallUntilClosed(const std::shared_ptr<grpc::Channel>& channel, bool asks_much,
                     const std::atomic<Clock::time_point>& stop, Outcomes& outcomes) {
  const auto admin = v1::AdminService::NewStub(channel);
  const auto query = v1::QueryService::NewStub(channel);
  v1::GetDistancesRequest request;
  *request.mutable_subject() = SphereAt(std::vector<double>(asks_much ? 5'000 : 1, 0.5));
  for (bool goes_on = true; goes_on;) {
    Call call;
    v1::GetServerInfoResponse info;
    v1::GetDistancesResponse answer;
    const auto begun = Clock::now();
    const grpc::Status status = asks_much ? query->GetDistances(&call, request, &answer)
                                          : admin->GetServerInfo(&call, {}, &info);
    if (status.ok()) {
      ++outcomes.answered;
    } else if (status.error_code() != grpc::StatusCode::UNAVAILABLE) {
      ++outcomes.other;
      ADD_FAILURE() << status.error_code() << ": " << status.error_message();
      goes_on = false;
    } else if (status.error_details().empty()) {
      ++(begun + kMinHeadStart < stop.load() ? outcomes.closed_though_early : outcomes.closed);
      goes_on = false;
    } else {
      ExpectDraining(status);
      ++outcomes.draining_errors;
    }
  }
}

TEST_F(DrainTest, EachCallOfBusyClientsEndsWithItsAnswerOrWithTheReason) {
  constexpr int kRounds = 15;
  Outcomes outcomes;
  for (int round = 0; round < kRounds; ++round) {
    const testing::ScratchDirectory scratch;
    Application application{.limits = {}, .retention = {}, .interpret = {}};
    address_ = "unix:" + (scratch / "cwm.sock");
    auto server = Server::Start(application, {.addresses = {address_}});
    ASSERT_TRUE(server.ok()) << server.status();
    ASSERT_TRUE(application.worlds.FindOrCreate("").ok());
    std::atomic<Clock::time_point> stop = Clock::time_point::max();
    std::vector<std::jthread> clients;
    const auto shared = DialAlone();  // shared by three clients, whose calls use one connection
    for (int i = 0; i < 6; ++i) {
      const auto channel = i < 3 ? shared : DialAlone();
      clients.emplace_back([&outcomes, &stop, channel, i] {
        CallUntilClosed(channel, /*asks_much=*/i % 2 == 1, stop, outcomes);
      });
    }
    std::this_thread::sleep_for(milliseconds(50 + 3 * round));
    const auto begun = Clock::now();
    stop = begun;
    (*server)->Stop(kLong);
    EXPECT_LT(Clock::now() - begun, 2 * kSoon);
  }
  RecordProperty("answered", outcomes.answered);
  RecordProperty("told", outcomes.draining_errors);
  RecordProperty("closed", outcomes.closed);
  EXPECT_GT(outcomes.answered, 0);
  EXPECT_GT(outcomes.draining_errors, 0);
  EXPECT_EQ(outcomes.closed_though_early, 0);
  EXPECT_EQ(outcomes.other, 0);
}

// Uploads of a robot, a cloud and a mesh after their first message.
TEST_F(DrainTest, HalfOpenUploadsEndAtOnce) {
  Call cloud_call;
  v1::IngestCloudResponse cloud_reply;
  const auto cloud = perception_->IngestCloud(&cloud_call, &cloud_reply);
  Call robot_call;
  v1::LoadRobotResponse robot_reply;
  const auto robot = robot_->LoadRobot(&robot_call, &robot_reply);
  Call mesh_call;
  v1::WriteGeometryResponse mesh_reply;
  const auto mesh = world_->WriteGeometry(&mesh_call, &mesh_reply);
  v1::WriteGeometryRequest header;
  header.mutable_header()->set_total_bytes(1'000);
  ASSERT_TRUE(mesh->Write(header));
  v1::LoadRobotRequest robot_header;
  robot_header.mutable_header()->set_urdf("<robot name='r'><link name='l'/></robot>");
  ASSERT_TRUE(robot->Write(robot_header));
  std::this_thread::sleep_for(milliseconds(100));  // until all three have arrived
  EXPECT_LT(TimeOfStop(kLong), kSoon);
  ExpectDraining(cloud->Finish());
  ExpectDraining(robot->Finish());
  ExpectDraining(mesh->Finish());
}

TEST_F(DrainTest, WhatWaitsForItsTurnIsRefusedAndWhatHasBegunIsAnswered) {
  PutBox("a", 0);
  const auto world = *application_.worlds.Find("");
  std::binary_semaphore taken{0};
  std::binary_semaphore release{0};
  std::jthread holder([&] {
    const auto outcome = world->Update(
        [&](const SnapshotPtr&) {
          taken.release();
          release.acquire();
          return std::vector<collision::Change>{};
        },
        {});
    EXPECT_TRUE(outcome.ok()) << outcome.status();
  });
  taken.acquire();
  const int under_way = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  const int waiting = 10;
  std::atomic<int> answered = 0;
  std::atomic<int> draining_errors = 0;
  std::vector<std::jthread> writers;
  for (int i = 0; i < under_way + waiting; ++i) {
    writers.emplace_back([&] {
      Call call;
      v1::ApplyChangesRequest request;
      *request.add_changes() = PutBoxChange("b", 1);
      v1::ApplyChangesResponse response;
      const grpc::Status status = world_->ApplyChanges(&call, request, &response);
      if (status.ok()) {
        ++answered;
      } else {
        ExpectDraining(status);
        ++draining_errors;
      }
    });
  }
  std::this_thread::sleep_for(milliseconds(300));  // until all have arrived
  std::jthread stopper([this] { server_->Stop(kLong); });
  std::this_thread::sleep_for(milliseconds(700));  // longer than it waits for idle clients
  EXPECT_EQ(answered + draining_errors, 0);
  release.release();
  writers.clear();
  stopper.join();
  EXPECT_EQ(answered, under_way);
  EXPECT_EQ(draining_errors, waiting);
}

TEST_F(DrainTest, WorkThatIsStoppedAfterTheGraceSaysWhy) {
  std::binary_semaphore begun{0};
  application_.interpret = [&](const auto&, const auto&, std::stop_token stop) {
    begun.release();
    while (!stop.stop_requested()) std::this_thread::sleep_for(milliseconds(1));
    return absl::StatusOr<perception::SceneInterpretation>(absl::CancelledError("stopped"));
  };
  Call ingest;
  v1::IngestCloudResponse ignored;
  const auto writer = SendOnePoint(&ingest, &ignored);
  begun.acquire();
  constexpr auto kGrace = milliseconds(700);
  const auto time = TimeOfStop(kGrace);
  EXPECT_GE(time, kGrace);
  EXPECT_LT(time, kGrace + kSoon);
  ExpectDraining(writer->Finish());
}

TEST_F(DrainTest, AClientThatReadsNothingDoesNotHoldItUp) {
  for (int i = 0; i < 300; ++i) PutBox("box_" + std::to_string(i), i);
  // The answers exceed the buffers of gRPC and the socket for a client that does not read.
  v1::GetDistancesRequest much;
  *much.mutable_subject() = SphereAt(std::vector<double>(50'000, 0.5));
  Call stream_call(kLong);
  const auto stream = query_->StreamQueries(&stream_call);
  v1::StreamQueriesRequest request;
  *request.mutable_get_distances() = much;
  for (int i = 0; i < 3; ++i) {
    request.set_id(static_cast<std::uint64_t>(i));
    if (!stream->Write(request)) break;
  }
  Call watch_call(kLong);
  const auto watch = world_->WatchWorld(&watch_call, {});
  std::this_thread::sleep_for(milliseconds(500));
  EXPECT_LT(TimeOfStop(kLong), 3 * kSoon);
}

TEST_F(DrainTest, AStopWithoutGraceStopsWhatIsUnderWay) {
  Call watch_call;
  const auto watch = world_->WatchWorld(&watch_call, {});
  Call upload_call;
  v1::WriteGeometryResponse reply;
  const auto upload = world_->WriteGeometry(&upload_call, &reply);
  EXPECT_LT(TimeOfStop(milliseconds(0)), kSoon);
  EXPECT_EQ(upload->Finish().error_code(), grpc::StatusCode::UNAVAILABLE);
}

}  // namespace
}  // namespace cwm::server
