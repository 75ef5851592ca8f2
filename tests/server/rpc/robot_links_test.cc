#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "proto/transfer/crc32c.h"
#include "proto/transfer/mesh_bytes.h"
#include "tests/collision/world/test_arm.h"
#include "tests/server/rpc/running_server.h"

namespace cwm::server {
namespace {

using collision::testing::ArmUrdf;
using collision::testing::Robot;

constexpr double kRounding = 1e-12;

class RobotLinksTest : public RunningServer {
 protected:
  // The elbow is turned by 0.5 rad about x, the slide extended by 0.25 m; the base is at x = 1.
  void LoadArm() {
    v1::LoadRobotHeader header;
    header.set_urdf(ArmUrdf());
    header.mutable_x_world_base()->set_tx_m(1);
    header.mutable_x_world_base()->set_qw(1);
    for (const auto& [name, value] : {std::pair("elbow", 0.5), std::pair("slide", 0.25)}) {
      v1::VariableValue* variable = header.mutable_initial_state()->add_values();
      variable->set_variable(name);
      variable->set_value(value);
    }
    MustLoad(header, "", "");
  }
  void MustLoad(const v1::LoadRobotHeader& header, const std::string& file,
                const std::string& bytes) {
    Call call;
    v1::LoadRobotResponse response;
    const auto writer = robot_->LoadRobot(&call, &response);
    v1::LoadRobotRequest request;
    *request.mutable_header() = header;
    EXPECT_TRUE(writer->Write(request));
    if (!file.empty()) {
      request.mutable_file()->set_name(file);
      request.mutable_file()->set_total_bytes(static_cast<std::int64_t>(bytes.size()));
      EXPECT_TRUE(writer->Write(request));
      request.mutable_chunk()->set_data(bytes);
      request.mutable_chunk()->set_crc32c(Crc32c(bytes));
      EXPECT_TRUE(writer->Write(request));
    }
    request.mutable_finish();
    EXPECT_TRUE(writer->Write(request));
    writer->WritesDone();
    const grpc::Status status = writer->Finish();
    ASSERT_TRUE(status.ok()) << status.error_message();
  }
  grpc::Status Get(const v1::GetRobotLinksRequest& request, v1::GetRobotLinksResponse* response) {
    Call call;
    response->Clear();
    return robot_->GetRobotLinks(&call, request, response);
  }
  v1::GetRobotLinksResponse MustGet(const std::string& name, bool with_shapes) {
    v1::GetRobotLinksRequest request;
    request.set_name(name);
    request.set_with_shapes(with_shapes);
    v1::GetRobotLinksResponse response;
    const grpc::Status status = Get(request, &response);
    EXPECT_TRUE(status.ok()) << status.error_message();
    return response;
  }
};

TEST_F(RobotLinksTest, LinksAreWhereTheStateHasThem) {
  LoadArm();
  const v1::GetRobotLinksResponse links = MustGet("arm", false);
  EXPECT_EQ(links.revision(), 1);
  EXPECT_FALSE(links.world_uid().empty());
  EXPECT_FALSE(links.robot_uid().empty());
  v1::ListRobotsResponse listed;
  Call call;
  ASSERT_TRUE(robot_->ListRobots(&call, {}, &listed).ok());
  ASSERT_EQ(links.links_size(), listed.robots(0).links_size());
  for (int i = 0; i < links.links_size(); ++i) {
    const v1::PlacedLink& link = links.links(i);
    EXPECT_EQ(link.link(), listed.robots(0).links(i).name());
    EXPECT_EQ(link.shapes_size(), 0);
    const bool is_turned = link.link() != "base" && link.link() != "free";
    const bool is_out = is_turned && link.link() != "upper";
    EXPECT_NEAR(link.x_world_link().tx_m(), is_out ? 1.25 : 1, kRounding) << link.link();
    EXPECT_NEAR(link.x_world_link().qx(), is_turned ? std::sin(0.25) : 0, kRounding) << link.link();
  }
}

TEST_F(RobotLinksTest, ShapesAreThoseOfTheUrdf) {
  LoadArm();
  const v1::GetRobotLinksResponse links = MustGet("arm", true);
  for (const v1::PlacedLink& link : links.links()) {
    if (link.link() == "tip") {
      ASSERT_EQ(link.shapes_size(), 2);
      EXPECT_EQ(link.shapes(1).box().size_x_m(), 0.1);
    } else if (link.link() == "base" || link.link() == "upper") {
      ASSERT_EQ(link.shapes_size(), 1);
      EXPECT_EQ(link.shapes(0).sphere().radius_m(), 0.1);
      EXPECT_EQ(link.shapes(0).x_object_shape().tz_m(), 0.2) << "in the link's frame";
    } else {
      EXPECT_EQ(link.shapes_size(), 0) << link.link();
    }
  }
}

TEST_F(RobotLinksTest, MeshesAreReadByTheirHash) {
  v1::LoadRobotHeader header;
  header.set_urdf(
      Robot("<link name=\"hand\"><collision><geometry><mesh "
            "filename=\"package://hand.obj\"/></geometry></collision></link>\n"));
  header.set_name("hand");
  MustLoad(header, "package://hand.obj", kTetrahedron);
  const v1::GetRobotLinksResponse links = MustGet("hand", true);
  v1::ReadGeometryRequest request;
  request.set_hash(links.links(0).shapes(0).mesh().hash());
  Call call;
  const auto reader = world_->ReadGeometry(&call, request);
  v1::ReadGeometryResponse chunk;
  ASSERT_TRUE(reader->Read(&chunk));
  EXPECT_EQ(chunk.format(), v1::GEOMETRY_FORMAT_MESH_F64);
  EXPECT_EQ(chunk.header().vertex_count(), 4);
  EXPECT_EQ(chunk.header().triangle_count(), 4);
}

TEST_F(RobotLinksTest, AnEarlierRevisionIsAnsweredAsItWas) {
  LoadArm();
  v1::ApplyChangesRequest move;
  v1::SetRobotState* set = move.add_changes()->mutable_robot_state();
  set->set_name("arm");
  set->mutable_x_world_base()->set_tx_m(5);
  set->mutable_x_world_base()->set_qw(1);
  v1::ApplyChangesResponse applied;
  Call call;
  ASSERT_TRUE(world_->ApplyChanges(&call, move, &applied).ok());
  EXPECT_EQ(MustGet("arm", false).links(0).x_world_link().tx_m(), 5);
  v1::GetRobotLinksRequest request;
  request.set_name("arm");
  request.mutable_at_revision()->set_exact(1);
  v1::GetRobotLinksResponse response;
  ASSERT_TRUE(Get(request, &response).ok());
  EXPECT_EQ(response.revision(), 1);
  EXPECT_EQ(response.links(0).x_world_link().tx_m(), 1);
  request.mutable_at_revision()->set_exact(77);
  EXPECT_EQ(ReasonIn(Get(request, &response)), "REVISION_IN_FUTURE");
}

TEST_F(RobotLinksTest, BadQueriesAreRefused) {
  LoadArm();
  v1::GetRobotLinksRequest request;
  v1::GetRobotLinksResponse response;
  EXPECT_EQ(FieldIn(Get(request, &response)), "name");
  request.set_name("a b");
  EXPECT_EQ(FieldIn(Get(request, &response)), "name");
  request.set_name("leg");
  EXPECT_EQ(Get(request, &response).error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_EQ(ReasonIn(Get(request, &response)), "ROBOT_UNKNOWN");
  request.set_name("arm");
  request.set_world("nowhere");
  EXPECT_EQ(ReasonIn(Get(request, &response)), "WORLD_UNKNOWN");
  request.clear_world();
  request.set_world_uid("another");
  EXPECT_EQ(ReasonIn(Get(request, &response)), "WORLD_REPLACED");
  request.clear_world_uid();
  request.mutable_at_revision()->set_exact(-1);
  EXPECT_EQ(Get(request, &response).error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  ExpectRevision(1);
}

}  // namespace
}  // namespace cwm::server
