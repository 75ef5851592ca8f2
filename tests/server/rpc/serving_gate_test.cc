#include "server/rpc/serving_gate.h"

#include <gmock/gmock.h>
#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>

#include "grpc/health/v1/health.grpc.pb.h"
#include "perception/interpret_scene.h"
#include "tests/server/rpc/running_server.h"

namespace cwm::server {
namespace {

using ::testing::HasSubstr;

// A server that listens and restores its worlds.
class ServingGateTest : public ::testing::Test {
 protected:
  ServingGateTest() {
    application_.store = "sqlite:/somewhere";
    application_.gate.Close();
    application_.gate.SetProgress(0.43);
    auto server = Server::Start(application_, {.addresses = {address_}});
    if (!server.ok()) throw std::runtime_error(std::string(server.status().message()));
    server_ = *std::move(server);
    channel_ = grpc::CreateChannel(address_, grpc::InsecureChannelCredentials());
    world_ = v1::WorldService::NewStub(channel_);
  }

  grpc::health::v1::HealthCheckResponse::ServingStatus Health(const std::string& service) const {
    Call call;
    grpc::health::v1::HealthCheckRequest request;
    request.set_service(service);
    grpc::health::v1::HealthCheckResponse response;
    const auto stub = grpc::health::v1::Health::NewStub(channel_);
    const grpc::Status status = stub->Check(&call, request, &response);
    EXPECT_TRUE(status.ok()) << status.error_message();
    return response.status();
  }
  v1::GetServerInfoResponse Info() const {
    Call call;
    v1::GetServerInfoResponse info;
    const grpc::Status status =
        v1::AdminService::NewStub(channel_)->GetServerInfo(&call, {}, &info);
    EXPECT_TRUE(status.ok()) << status.error_message();
    return info;
  }

  testing::ScratchDirectory scratch_;
  Application application_{.limits = {}, .retention = {}, .interpret = perception::InterpretScene};
  std::string address_ = "unix:" + (scratch_ / "cwm.sock");
  std::unique_ptr<Server> server_;
  std::shared_ptr<grpc::Channel> channel_;
  std::unique_ptr<v1::WorldService::Stub> world_;
};

void ExpectReplaying(const grpc::Status& status) {
  EXPECT_EQ(status.error_code(), grpc::StatusCode::UNAVAILABLE);
  EXPECT_THAT(status.error_message(), HasSubstr("43 %"));
  const Details details = DetailsIn(status);
  EXPECT_EQ(details.info.reason(), "STORE_REPLAYING");
  EXPECT_EQ(details.info.metadata().at("progress"), "0.43");
  EXPECT_TRUE(details.has_retry);
}

TEST_F(ServingGateTest, RefusesUnaryCallsWithTheProgress) {
  Call call;
  v1::ListWorldsResponse worlds;
  ExpectReplaying(world_->ListWorlds(&call, {}, &worlds));
  Call put;
  v1::ApplyChangesRequest request;
  *request.add_changes() = PutBoxChange("box", 0);
  v1::ApplyChangesResponse response;
  ExpectReplaying(world_->ApplyChanges(&put, request, &response));
}

TEST_F(ServingGateTest, RefusesCallsThatSendOrReceiveStreams) {
  Call watch_call;
  v1::WatchWorldResponse event;
  const auto watch = world_->WatchWorld(&watch_call, {});
  EXPECT_FALSE(watch->Read(&event));
  ExpectReplaying(watch->Finish());

  Call export_call;
  v1::ExportWorldResponse chunk;
  const auto exported = world_->ExportWorld(&export_call, {});
  EXPECT_FALSE(exported->Read(&chunk));
  ExpectReplaying(exported->Finish());

  Call read_call;
  v1::ReadGeometryResponse geometry;
  const auto reader = world_->ReadGeometry(&read_call, {});
  EXPECT_FALSE(reader->Read(&geometry));
  ExpectReplaying(reader->Finish());

  Call robot_call;
  v1::LoadRobotResponse robot;
  const auto writer = v1::RobotService::NewStub(channel_)->LoadRobot(&robot_call, &robot);
  ExpectReplaying(writer->Finish());

  Call stream_call;
  v1::StreamQueriesResponse answer;
  const auto stream = v1::QueryService::NewStub(channel_)->StreamQueries(&stream_call);
  EXPECT_FALSE(stream->Read(&answer));
  ExpectReplaying(stream->Finish());

  Call backup_call;
  v1::BackUpResponse piece;
  const auto backup = v1::AdminService::NewStub(channel_)->BackUp(&backup_call, {});
  EXPECT_FALSE(backup->Read(&piece));
  ExpectReplaying(backup->Finish());
}

TEST_F(ServingGateTest, SaysMeanwhileThatItDoesNotServe) {
  using Response = grpc::health::v1::HealthCheckResponse;
  EXPECT_EQ(Health(""), Response::NOT_SERVING);
  EXPECT_EQ(Health("cwm.v1.WorldService"), Response::NOT_SERVING);
  const v1::GetServerInfoResponse info = Info();
  EXPECT_EQ(info.store(), "sqlite:/somewhere");
  EXPECT_DOUBLE_EQ(info.store_info().replayed(), 0.43);
}

TEST_F(ServingGateTest, ServesOnceItIsOpen) {
  server_->OpenGate();
  using Response = grpc::health::v1::HealthCheckResponse;
  EXPECT_EQ(Health(""), Response::SERVING);
  EXPECT_EQ(Health("cwm.v1.WorldService"), Response::SERVING);
  Call call;
  v1::ListWorldsResponse worlds;
  EXPECT_TRUE(world_->ListWorlds(&call, {}, &worlds).ok());
  EXPECT_EQ(Info().store_info().replayed(), 1);
  EXPECT_GT(Info().store_info().replay_seconds(), 0);
}

TEST(ServingGate, EstimatesWhenItOpensFromTheProgress) {
  ServingGate gate;
  EXPECT_TRUE(gate.Check().ok()) << "a gate that nobody closes is open";
  gate.Close();
  EXPECT_EQ(DetailsOf(gate.Check()).metadata.at("progress"), "0");
  gate.SetProgress(2);
  EXPECT_EQ(gate.progress(), 1);
  EXPECT_FALSE(gate.Check().ok()) << "only Open opens it";
  gate.Open();
  EXPECT_TRUE(gate.Check().ok());
}

}  // namespace
}  // namespace cwm::server
