#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "grpc/health/v1/health.grpc.pb.h"
#include "proto/transfer/crc32c.h"
#include "tests/collision/world/test_arm.h"
#include "tests/server/rpc/running_server.h"

namespace cwm::server {
namespace {

using collision::testing::ArmSrdf;
using collision::testing::ArmUrdf;
using collision::testing::JointText;
using collision::testing::Links;
using collision::testing::Robot;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using Files = std::map<std::string, std::string>;
using Loading = grpc::ClientWriter<v1::LoadRobotRequest>;

std::string MeshRobot(const std::string& uri) {
  return Robot("<link name=\"hand\"><collision><geometry><mesh filename=\"" + uri +
               "\"/></geometry></collision></link>\n");
}

v1::LoadRobotHeader ArmHeader() {
  v1::LoadRobotHeader header;
  header.set_urdf(ArmUrdf());
  header.set_srdf(ArmSrdf());
  return header;
}

v1::LoadRobotRequest FileOf(const std::string& name, std::int64_t total_bytes) {
  v1::LoadRobotRequest request;
  request.mutable_file()->set_name(name);
  request.mutable_file()->set_total_bytes(total_bytes);
  return request;
}

v1::LoadRobotRequest ChunkOf(const std::string& data, std::int64_t offset) {
  v1::LoadRobotRequest request;
  request.mutable_chunk()->set_offset(offset);
  request.mutable_chunk()->set_data(data);
  request.mutable_chunk()->set_crc32c(Crc32c(data));
  return request;
}

class RobotServiceTest : public RunningServer {
 protected:
  using RunningServer::RunningServer;

  grpc::Status Send(const std::vector<v1::LoadRobotRequest>& messages) {
    Call call;
    response_.Clear();
    const auto writer = robot_->LoadRobot(&call, &response_);
    for (const v1::LoadRobotRequest& message : messages) {
      if (!writer->Write(message)) break;
    }
    writer->WritesDone();
    return writer->Finish();
  }
  grpc::Status Load(const v1::LoadRobotHeader& header, const Files& files = {}) {
    std::vector<v1::LoadRobotRequest> messages(1);
    *messages[0].mutable_header() = header;
    constexpr std::size_t kChunk = 40;  // so that a mesh takes several chunks
    for (const auto& [name, bytes] : files) {
      messages.push_back(FileOf(name, static_cast<std::int64_t>(bytes.size())));
      for (std::size_t at = 0; at < bytes.size(); at += kChunk) {
        messages.push_back(ChunkOf(bytes.substr(at, kChunk), static_cast<std::int64_t>(at)));
      }
    }
    messages.emplace_back().mutable_finish();
    return Send(messages);
  }
  grpc::Status LoadUrdf(const std::string& urdf, const Files& files = {}) {
    v1::LoadRobotHeader header;
    header.set_urdf(urdf);
    return Load(header, files);
  }
  void MustLoad(const v1::LoadRobotHeader& header, const Files& files = {}) {
    const grpc::Status status = Load(header, files);
    ASSERT_TRUE(status.ok()) << status.error_message();
  }
  // Expects a refusal that leaves the server unaffected.
  void ExpectBadFile(const std::string& urdf, const std::string& rule) {
    const grpc::Status status = LoadUrdf(urdf);
    EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT) << status.error_message();
    EXPECT_EQ(FieldIn(status), "header.urdf");
    EXPECT_THAT(status.error_message(), HasSubstr(rule));
  }
  grpc::Status List(const v1::ListRobotsRequest& request, v1::ListRobotsResponse* response) {
    Call call;
    response->Clear();
    return robot_->ListRobots(&call, request, response);
  }
  std::vector<std::string> Names() {
    v1::ListRobotsResponse listed;
    EXPECT_TRUE(List({}, &listed).ok());
    std::vector<std::string> names;
    for (const v1::Robot& robot : listed.robots()) names.push_back(robot.name());
    return names;
  }
  grpc::Status Delete(const v1::DeleteRobotRequest& request,
                      v1::DeleteRobotResponse* response = nullptr) {
    Call call;
    v1::DeleteRobotResponse ignored;
    return robot_->DeleteRobot(&call, request, response != nullptr ? response : &ignored);
  }
  grpc::Status SetElbow(const std::string& name, double value) {
    Call call;
    v1::ApplyChangesRequest request;
    v1::SetRobotState* set = request.add_changes()->mutable_robot_state();
    set->set_name(name);
    v1::VariableValue* elbow = set->mutable_joints()->add_values();
    elbow->set_variable("elbow");
    elbow->set_value(value);
    v1::ApplyChangesResponse response;
    return world_->ApplyChanges(&call, request, &response);
  }

  v1::LoadRobotResponse response_;
};

TEST_F(RobotServiceTest, LoadsARobotAndMakesItsWorld) {
  v1::LoadRobotHeader header = ArmHeader();
  header.set_world("kitchen");
  header.set_name("left");
  header.mutable_x_world_base()->set_tx_m(1);
  header.mutable_x_world_base()->set_qw(1);
  header.mutable_initial_state()->set_group("reach");
  header.mutable_initial_state()->set_named_state("ready");
  MustLoad(header);
  EXPECT_EQ(response_.revision(), 1);
  EXPECT_EQ(response_.robot().name(), "left");
  EXPECT_EQ(response_.robot().uid(), "left@1");
  EXPECT_EQ(response_.robot().links_size(), 7);
  EXPECT_EQ(response_.robot().state(0), 0.5);
  EXPECT_EQ(response_.robot().x_world_base().tx_m(), 1);
  EXPECT_EQ(response_.warnings_size(), 2);
  ExpectRevision(1, "kitchen");
  MustLoad(header);
  ExpectRevision(1, "kitchen");
}

TEST_F(RobotServiceTest, FindsFilesByTheNamesThatTheUrdfHas) {
  const Files files = {{"package://p/hand.obj", kTetrahedron},
                       {"r.urdf", MeshRobot("package://p/hand.obj")}};
  v1::LoadRobotHeader header;
  header.set_urdf_file("r.urdf");
  MustLoad(header, files);
  EXPECT_EQ(response_.robot().links(0).triangle_count(), 4);
  ASSERT_EQ(response_.warnings_size(), 1);
  EXPECT_THAT(response_.warnings(0), HasSubstr("no SRDF"));
  const grpc::Status missing = LoadUrdf(MeshRobot("package://q/hand.obj"), files);
  EXPECT_EQ(missing.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(FieldIn(missing), "header.urdf");
  EXPECT_THAT(missing.error_message(), HasSubstr("link \"hand\""));
  EXPECT_THAT(missing.error_message(), HasSubstr("package://q/hand.obj"));
  header.set_urdf_file("s.urdf");
  EXPECT_EQ(FieldIn(Load(header, files)), "header.urdf_file");
}

TEST_F(RobotServiceTest, RefusesBadFilesAndMakesNoWorld) {
  ExpectBadFile(
      Robot(Links("ab") + JointText("j", "fixed", "a", "b") + JointText("k", "fixed", "b", "a")),
      "");
  ExpectBadFile(Robot(Links("ab") + JointText("j", "revolute", "a", "b", "")), "limit");
  ExpectBadFile(Robot(Links("ab") + JointText("j", "fixed", "a", "b", "<origin rpy=\"0 nan 0\"/>")),
                "nan");
  ExpectBadFile("<!DOCTYPE r [<!ENTITY a \"&b;&b;\">]><robot name=\"&a;\"/>", "DOCTYPE");
  ExpectBadFile("no xml", "");
  ExpectBadFile(MeshRobot("x.obj"), "must be one of the files sent along");
  v1::LoadRobotHeader header = ArmHeader();
  header.set_srdf("<robot name=\"arm\"><group name=\"g\"><group name=\"g\"/></group></robot>");
  EXPECT_EQ(FieldIn(Load(header)), "header.srdf");
  header = ArmHeader();
  header.mutable_initial_state()->set_group("reach");
  header.mutable_initial_state()->set_named_state("home");
  EXPECT_EQ(FieldIn(Load(header)), "header.initial_state.named_state");
  header.clear_initial_state();
  header.mutable_initial_state()->add_values()->set_variable("knee");
  EXPECT_EQ(FieldIn(Load(header)), "header.initial_state.values[0].variable");
  header.mutable_initial_state()->mutable_values(0)->set_value(std::nan(""));
  EXPECT_EQ(FieldIn(Load(header)), "header.initial_state.values[0].value");
  Call call;
  v1::ListWorldsResponse worlds;
  ASSERT_TRUE(world_->ListWorlds(&call, {}, &worlds).ok());
  EXPECT_EQ(worlds.worlds_size(), 0);
  MustLoad(ArmHeader());
}

TEST_F(RobotServiceTest, RefusesMessagesThatAreNoUpload) {
  v1::LoadRobotRequest header, finish;
  *header.mutable_header() = ArmHeader();
  finish.mutable_finish();
  EXPECT_EQ(FieldIn(Send({})), "header");
  EXPECT_EQ(FieldIn(Send({finish})), "finish");
  EXPECT_EQ(FieldIn(Send({FileOf("a", 1)})), "file");
  EXPECT_EQ(FieldIn(Send({header})), "finish");
  EXPECT_EQ(FieldIn(Send({header, header})), "header");
  EXPECT_EQ(FieldIn(Send({header, finish, finish})), "what");
  EXPECT_EQ(FieldIn(Send({header, ChunkOf("x", 0)})), "chunk");
  EXPECT_EQ(FieldIn(Send({header, FileOf("", 1)})), "file.name");
  EXPECT_EQ(FieldIn(Send({header, FileOf("a", -1)})), "file.total_bytes");
  EXPECT_EQ(FieldIn(Send({header, FileOf("a", 0), FileOf("a", 0)})), "file.name");
  EXPECT_EQ(FieldIn(Send({header, FileOf("a", 2), ChunkOf("x", 0), FileOf("b", 1)})), "file");
  EXPECT_EQ(FieldIn(Send({header, FileOf("a", 2), ChunkOf("x", 0), finish})), "finish");
  EXPECT_EQ(FieldIn(Send({header, FileOf("a", 2), ChunkOf("x", 1)})), "chunk.offset");
  v1::LoadRobotRequest broken = ChunkOf("x", 0);
  broken.mutable_chunk()->set_data("y");
  EXPECT_EQ(FieldIn(Send({header, FileOf("a", 2), broken})), "chunk.crc32c");
}

class SmallRobotServer : public RobotServiceTest {
 protected:
  static Limits Small() {
    Limits limits;
    limits.max_robot_bytes = 200;
    limits.max_robot_files = 2;
    limits.max_robots = 1;
    limits.robot.max_links = 7;
    limits.robot.max_triangles = 3;
    return limits;
  }
  SmallRobotServer() : RobotServiceTest(Small(), Retention{}) {}

  void ExpectTooLarge(const grpc::Status& status, const std::string& limit) {
    EXPECT_EQ(status.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED) << status.error_message();
    EXPECT_THAT(status.error_message(), HasSubstr(limit));
  }
};

TEST_F(SmallRobotServer, NamesTheLimitThatARobotExceeds) {
  v1::LoadRobotRequest header;
  *header.mutable_header() = ArmHeader();
  ExpectTooLarge(Send({header, FileOf("a", 201)}), "max_robot_bytes");
  ExpectTooLarge(Send({header, FileOf("a", 0), FileOf("b", 0), FileOf("c", 0)}), "max_robot_files");
  ExpectTooLarge(LoadUrdf(Robot(Links("abcdefgh"))), "at most 7 links");
  ExpectTooLarge(LoadUrdf(MeshRobot("a.obj"), {{"a.obj", kTetrahedron}}), "at most 3 triangles");
  MustLoad(ArmHeader());
  v1::LoadRobotHeader second = ArmHeader();
  second.set_name("second");
  ExpectTooLarge(Load(second), "max_robots");
}

TEST_F(RobotServiceTest, ListsInPagesOfOneRevision) {
  v1::LoadRobotHeader header = ArmHeader();
  for (const char* name : {"c", "a", "b"}) {
    header.set_name(name);
    MustLoad(header);
  }
  EXPECT_THAT(Names(), ElementsAre("a", "b", "c"));
  v1::ListRobotsRequest request;
  request.set_page_size(2);
  v1::ListRobotsResponse page;
  ASSERT_TRUE(List(request, &page).ok());
  ASSERT_EQ(page.robots_size(), 2);
  ASSERT_TRUE(SetElbow("c", 0.5).ok());
  request.set_page_token(page.next_page_token());
  ASSERT_TRUE(List(request, &page).ok());
  ASSERT_EQ(page.robots_size(), 1);
  EXPECT_EQ(page.revision(), 3);
  EXPECT_EQ(page.robots(0).state(0), 0) << "as it was at the first page";
  EXPECT_EQ(page.next_page_token(), "");
  request.set_name("c");
  EXPECT_EQ(FieldIn(List(request, &page)), "page_token") << "of another filter";
  request.clear_page_token();
  ASSERT_TRUE(List(request, &page).ok());
  EXPECT_EQ(page.robots(0).state(0), 0.5);
  request.set_name("ghost");
  EXPECT_EQ(ReasonIn(List(request, &page)), "ROBOT_UNKNOWN");
  request.set_world("nowhere");
  EXPECT_EQ(ReasonIn(List(request, &page)), "WORLD_UNKNOWN");
}

TEST_F(RobotServiceTest, SetsTheStateByApplyChanges) {
  MustLoad(ArmHeader());
  ASSERT_TRUE(SetElbow("arm", 0.75).ok());
  v1::ListRobotsResponse listed;
  ASSERT_TRUE(List({}, &listed).ok());
  EXPECT_EQ(listed.revision(), 2);
  EXPECT_EQ(listed.robots(0).state(0), 0.75);
  EXPECT_EQ(listed.robots(0).create_revision(), 1);
  EXPECT_EQ(listed.robots(0).state_revision(), 2);
  const grpc::Status unknown = SetElbow("ghost", 0);
  EXPECT_EQ(unknown.error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_EQ(ReasonIn(unknown), "ROBOT_UNKNOWN");
  EXPECT_EQ(FieldIn(SetElbow("arm", std::nan(""))),
            "changes[0].robot_state.joints.values[0].value");
}

TEST_F(RobotServiceTest, DeletesARobotOnce) {
  MustLoad(ArmHeader());
  v1::DeleteRobotRequest request;
  request.set_name("arm");
  request.set_request_id("once");
  v1::DeleteRobotResponse response;
  ASSERT_TRUE(Delete(request, &response).ok());
  EXPECT_EQ(response.revision(), 2);
  response.Clear();
  ASSERT_TRUE(Delete(request, &response).ok()) << "a retry";
  EXPECT_EQ(response.revision(), 2);
  request.clear_request_id();
  const grpc::Status gone = Delete(request);
  EXPECT_EQ(gone.error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_EQ(ReasonIn(gone), "ROBOT_UNKNOWN");
  request.set_world("nowhere");
  EXPECT_EQ(ReasonIn(Delete(request)), "WORLD_UNKNOWN");
}

TEST_F(RobotServiceTest, ARetryGetsTheFirstReply) {
  v1::LoadRobotHeader header = ArmHeader();
  header.set_request_id("load-1");
  MustLoad(header);
  const v1::LoadRobotResponse first = response_;
  ASSERT_TRUE(SetElbow("arm", 0.5).ok());
  MustLoad(header);
  EXPECT_EQ(response_.SerializeAsString(), first.SerializeAsString());
  ExpectRevision(2);
  header.set_name("other");
  EXPECT_EQ(ReasonIn(Load(header)), "REQUEST_ID_REUSED");
  header.set_name("");
  EXPECT_EQ(ReasonIn(Load(header, {{"more", "bytes"}})), "REQUEST_ID_REUSED");
}

TEST_F(RobotServiceTest, ExpectsTheRevisionThatTheWriterKnows) {
  MustLoad(ArmHeader());
  v1::LoadRobotHeader header = ArmHeader();
  header.set_name("second");
  header.set_expected_revision(7);
  EXPECT_EQ(ReasonIn(Load(header)), "REVISION_MISMATCH");
  header.set_expected_revision(1);
  MustLoad(header);
  v1::DeleteRobotRequest request;
  request.set_name("arm");
  request.set_expected_revision(1);
  EXPECT_EQ(ReasonIn(Delete(request)), "REVISION_MISMATCH");
}

TEST_F(RobotServiceTest, RobotsAndObjectsHaveDifferentNames) {
  PutBox("arm", 0);
  EXPECT_EQ(FieldIn(Load(ArmHeader())), "header.name");
  v1::LoadRobotHeader header = ArmHeader();
  header.set_name("left");
  MustLoad(header);
  Call call;
  v1::ApplyChangesRequest request;
  *request.add_changes() = PutBoxChange("left", 0);
  v1::ApplyChangesResponse response;
  EXPECT_EQ(FieldIn(world_->ApplyChanges(&call, request, &response)), "changes[0].name");
}

TEST_F(RobotServiceTest, WatchesShowRobots) {
  MustLoad(ArmHeader());
  Call call;
  const auto watch = world_->WatchWorld(&call, {});
  const auto next = [&] { return NextMessage(watch.get()); };
  const v1::WatchWorldResponse initial = next();
  ASSERT_EQ(initial.initial_state().robots_size(), 1);
  EXPECT_EQ(initial.initial_state().robots(0).name(), "arm");
  EXPECT_TRUE(initial.initial_state().initial_state_done());
  ASSERT_TRUE(SetElbow("arm", 0.25).ok());
  const v1::WatchWorldResponse moved = next();
  EXPECT_EQ(moved.revision(), 2);
  ASSERT_EQ(moved.events().robot_events_size(), 1);
  EXPECT_EQ(moved.events().robot_events(0).state().state(0), 0.25);
  v1::DeleteRobotRequest request;
  request.set_name("arm");
  ASSERT_TRUE(Delete(request).ok());
  EXPECT_EQ(next().events().robot_events(0).remove(), "arm");
  call.TryCancel();
}

TEST_F(RobotServiceTest, AWorldSaysHowManyRobotsItHas) {
  MustLoad(ArmHeader());
  Call call;
  v1::GetWorldResponse response;
  ASSERT_TRUE(world_->GetWorld(&call, {}, &response).ok());
  EXPECT_EQ(response.world().robot_count(), 1);
  EXPECT_EQ(response.world().object_count(), 0);
}

TEST_F(RobotServiceTest, IsHealthy) {
  Call call;
  grpc::health::v1::HealthCheckRequest request;
  request.set_service("cwm.v1.RobotService");
  grpc::health::v1::HealthCheckResponse response;
  const auto health = grpc::health::v1::Health::NewStub(Dial());
  ASSERT_TRUE(health->Check(&call, request, &response).ok());
  EXPECT_EQ(response.status(), grpc::health::v1::HealthCheckResponse::SERVING);
}

TEST_F(RobotServiceTest, AClientThatGoesAwayLeavesNothingBehind) {
  {
    Call call;
    const auto writer = robot_->LoadRobot(&call, &response_);
    v1::LoadRobotRequest header;
    *header.mutable_header() = ArmHeader();
    ASSERT_TRUE(writer->Write(header));
    call.TryCancel();
    EXPECT_EQ(writer->Finish().error_code(), grpc::StatusCode::CANCELLED);
  }
  Call call;
  v1::ListWorldsResponse worlds;
  ASSERT_TRUE(world_->ListWorlds(&call, {}, &worlds).ok());
  EXPECT_EQ(worlds.worlds_size(), 0);
}

}  // namespace
}  // namespace cwm::server
