// No client can use up the memory or the places of others: each refusal says what is full and when
// to retry, and other clients are answered meanwhile.
#include <gmock/gmock.h>

#include <list>
#include <memory>
#include <string>
#include <thread>

#include "tests/server/rpc/depth_stream.h"
#include "tests/server/rpc/running_server.h"

namespace cwm::server {
namespace {

using std::chrono::milliseconds;

constexpr std::int64_t kMebibyte = 1 << 20;

v1::ApplyChangesRequest Spheres(const std::string& world, int count) {
  v1::ApplyChangesRequest request;
  request.set_world(world);
  for (int i = 0; i < count; ++i) {
    v1::Object* object = request.add_changes()->mutable_put()->mutable_object();
    object->set_name("s" + std::to_string(i));
    object->add_shapes()->mutable_sphere()->set_radius_m(0.01);
  }
  return request;
}

class LittleMemoryTest : public RunningServer {
 protected:
  static Limits Little() {
    Limits limits;
    limits.max_memory_bytes = 16 * kMebibyte;
    limits.max_stall = milliseconds(300);
    return limits;
  }
  LittleMemoryTest() : RunningServer(Little(), {}) {}

  grpc::Status Apply(const v1::ApplyChangesRequest& request) {
    Call call;
    v1::ApplyChangesResponse response;
    return world_->ApplyChanges(&call, request, &response);
  }
};

TEST_F(LittleMemoryTest, RefusesWhatWorldsHaveNoRoomForAndGoesOn) {
  grpc::Status status;
  int worlds = 0;
  while (status.ok() && worlds < 100) {
    status = Apply(Spheres("w" + std::to_string(worlds++), 1'000));
  }
  EXPECT_EQ(status.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_EQ(ReasonIn(status), "MEMORY_EXHAUSTED") << status.error_message();
  EXPECT_TRUE(DetailsIn(status).has_retry);
  EXPECT_GT(worlds, 2);
  EXPECT_LE(application_.memory->world_bytes(), application_.memory->worlds_limit_bytes());
  // Everything else continues, and deletions free memory.
  Call get;
  v1::GetWorldRequest request;
  request.set_world("w0");
  v1::GetWorldResponse response;
  EXPECT_TRUE(world_->GetWorld(&get, request, &response).ok());
  v1::ApplyChangesRequest removal;
  removal.set_world("w0");
  removal.set_request_id("removal");
  removal.add_changes()->mutable_remove()->set_name("s0");
  EXPECT_TRUE(Apply(removal).ok());
  Call gone;
  v1::DeleteWorldRequest deletion;
  deletion.set_world("w0");
  v1::DeleteWorldResponse deleted;
  ASSERT_TRUE(world_->DeleteWorld(&gone, deletion, &deleted).ok());
  EXPECT_TRUE(Apply(Spheres("again", 500)).ok());
}

TEST_F(LittleMemoryTest, CountsWhatASensorTakesBesideItsPixels) {
  // A view of 192 pixels has tables of half a mebibyte.
  std::list<DepthStream> streams;
  grpc::Status status;
  while (status.ok() && streams.size() < 40) {
    DepthStream& stream = streams.emplace_back(*perception_);
    const v1::SensorCalibration calibration =
        SmallCamera("sensor_" + std::to_string(streams.size()), 16, 12);
    stream.Send(calibration);
    stream.Send(WallFrame(calibration, 2, 0));
    if (!stream.Next().has_value()) status = stream.Finish();
  }
  EXPECT_EQ(ReasonIn(status), "MEMORY_EXHAUSTED") << status.error_message();
  EXPECT_GT(streams.size(), 2U);
  EXPECT_LE(streams.size(), 17U);
}

TEST_F(LittleMemoryTest, AnswersNoQueryAsIfARefusedOverlayHadNotBeenGiven) {
  PutBox("a", 5);
  Call call;
  const auto stream = query_->StreamQueries(&call);
  v1::StreamQueriesRequest request;
  *request.mutable_overlay()->mutable_changes() = Spheres("", 12'000).changes();
  v1::StreamQueriesResponse response;
  ASSERT_TRUE(stream->Write(request) && stream->Read(&response));
  EXPECT_EQ(response.error().reason(), "MEMORY_EXHAUSTED") << response.error().message();
  request.Clear();
  *request.mutable_check_collisions()->mutable_subject() = SphereAt({0});
  ASSERT_TRUE(stream->Write(request) && stream->Read(&response));
  EXPECT_EQ(response.error().reason(), "MEMORY_EXHAUSTED");
  stream->WritesDone();
  stream->Finish();
}

TEST_F(LittleMemoryTest, EndsAnUploadThatSendsNothing) {
  Call call;
  v1::LoadRobotResponse response;
  const auto upload = robot_->LoadRobot(&call, &response);
  v1::LoadRobotRequest request;
  request.mutable_header()->set_name("arm");
  request.mutable_header()->set_urdf("<robot name='arm'><link name='base'/></robot>");
  ASSERT_TRUE(upload->Write(request));
  // The client sends nothing more; the server ends the call.
  const grpc::Status status = upload->Finish();
  EXPECT_EQ(status.error_code(), grpc::StatusCode::DEADLINE_EXCEEDED);
  EXPECT_EQ(ReasonIn(status), "UPLOAD_STALLED");
  // The call releases its memory a moment after its client has received the status.
  for (int i = 0; i < 1'000 && application_.memory->client_bytes() > 0; ++i) {
    std::this_thread::sleep_for(milliseconds(5));
  }
  EXPECT_EQ(application_.memory->client_bytes(), 0);
}

class FewUploadsTest : public RunningServer {
 protected:
  static Limits Few() {
    Limits limits;
    limits.max_client_uploads = 2;
    return limits;
  }
  FewUploadsTest() : RunningServer(Few(), {}) {}

  std::int64_t Uploads() {
    Call call;
    v1::GetStatsResponse stats;
    EXPECT_TRUE(admin_->GetStats(&call, {}, &stats).ok());
    return stats.uploads();
  }
};

TEST_F(FewUploadsTest, AreCountedForEachConnection) {
  struct Upload {
    Call call;
    v1::WriteGeometryResponse response;
    std::unique_ptr<grpc::ClientWriter<v1::WriteGeometryRequest>> wire;
  };
  std::list<Upload> uploads(2);
  for (Upload& upload : uploads) {
    upload.wire = world_->WriteGeometry(&upload.call, &upload.response);
    v1::WriteGeometryRequest header;
    header.mutable_header()->set_total_bytes(100);
    ASSERT_TRUE(upload.wire->Write(header));
  }
  const auto until = Clock::now() + std::chrono::seconds(20);
  while (Uploads() < 2 && Clock::now() < until) std::this_thread::sleep_for(milliseconds(1));
  v1::WriteGeometryResponse response;
  Call third;
  const auto refused = world_->WriteGeometry(&third, &response);
  const grpc::Status status = refused->Finish();
  EXPECT_EQ(ReasonIn(status), "TOO_MANY_UPLOADS") << status.error_message();
  EXPECT_TRUE(DetailsIn(status).has_retry);
  Call other;
  grpc::ChannelArguments alone;  // uses a connection of its own
  alone.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  const auto stub = v1::WorldService::NewStub(
      grpc::CreateCustomChannel(address_, grpc::InsecureChannelCredentials(), alone));
  const auto elsewhere = stub->WriteGeometry(&other, &response);
  elsewhere->WritesDone();
  EXPECT_EQ(FieldIn(elsewhere->Finish()), "header") << "it is admitted, and empty";
}

}  // namespace
}  // namespace cwm::server
