// Exports of worlds as files, over a real socket.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "proto/transfer/chunks.h"
#include "proto/transfer/mesh_bytes.h"
#include "server/core/geometry_store.h"
#include "server/export/moveit_scene.h"
#include "tests/collision/robot/robot_text.h"
#include "tests/server/rpc/running_server.h"

namespace cwm::server {
namespace {

using ::testing::HasSubstr;

class ExportTest : public RunningServer {
 protected:
  explicit ExportTest(const Limits& limits = {}) : RunningServer(limits, {}) {}

  struct Exported {
    grpc::Status status;
    std::vector<v1::ExportWorldResponse> messages;
  };

  Exported Export(const v1::ExportWorldRequest& request = {}) {
    Call call;
    const auto reader = world_->ExportWorld(&call, request);
    Exported exported;
    v1::ExportWorldResponse message;
    while (reader->Read(&message)) exported.messages.push_back(message);
    exported.status = reader->Finish();
    return exported;
  }

  // Puts `count` sheets that share a mesh.
  void PutSheets(int count, const TriangleMesh& mesh) {
    const auto stored = application_.geometry.Put(BlobFormat::kMeshF64, EncodeMesh(mesh));
    ASSERT_TRUE(stored.ok()) << stored.status();
    std::vector<v1::Change> changes;
    for (int i = 0; i < count; ++i) {
      v1::Object* object = changes.emplace_back().mutable_put()->mutable_object();
      object->set_name("sheet" + std::to_string(i));
      object->add_shapes()->mutable_mesh()->set_hash(stored->hash);
    }
    Apply(changes);
  }

  void Apply(const std::vector<v1::Change>& changes) {
    Call call;
    v1::ApplyChangesRequest request;
    request.mutable_changes()->Assign(changes.begin(), changes.end());
    v1::ApplyChangesResponse response;
    const grpc::Status status = world_->ApplyChanges(&call, request, &response);
    ASSERT_TRUE(status.ok()) << status.error_message();
  }
};

// A file that is not read for long is freed and made again.
TEST_F(ExportTest, IsTheSameForAReaderThatPauses) {
  PutSheets(1, Strip(200'000));
  v1::ExportWorldRequest request;
  request.set_format(v1::EXPORT_FORMAT_GLB);
  const auto bytes_of = [](const std::vector<v1::ExportWorldResponse>& messages) {
    std::string bytes;
    for (const v1::ExportWorldResponse& message : messages) bytes += message.data();
    return bytes;
  };
  const std::string at_once = bytes_of(Export(request).messages);
  Call call;
  const auto reader = world_->ExportWorld(&call, request);
  std::vector<v1::ExportWorldResponse> messages(1);
  ASSERT_TRUE(reader->Read(&messages.back()));
  ASSERT_GT(messages.back().total_bytes(), 4 * messages.back().data().size());
  const auto until = Clock::now() + std::chrono::seconds(20);
  const auto held = [this] { return application_.memory->client_bytes(); };
  while (held() > messages.back().total_bytes() / 2 && Clock::now() < until) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  EXPECT_LT(held(), messages.back().total_bytes() / 2);
  PutBox("another", 1);  // the reader's file is of the earlier revision
  v1::ExportWorldResponse message;
  while (reader->Read(&message)) messages.push_back(message);
  EXPECT_TRUE(reader->Finish().ok());
  EXPECT_EQ(bytes_of(messages), at_once);
}

TEST_F(ExportTest, ComesInChunksOfWhichTheLastIsDone) {
  PutSheets(1, Strip(80'000));
  const Exported exported = Export();
  ASSERT_TRUE(exported.status.ok()) << exported.status.error_message();
  const std::shared_ptr<World> world = *application_.worlds.Find("default");
  const auto snapshot = world->At(Latest{}, Clock::time_point::max(), {});
  ASSERT_TRUE(snapshot.ok()) << snapshot.status();
  auto scene = MakePlanningScene(**snapshot, 1'000'000);
  ASSERT_TRUE(scene.ok()) << scene.status();
  scene->name = "default";
  const std::string expected = FormatSceneText(*scene).value();
  ASSERT_GT(exported.messages.size(), 2u);
  std::string received;
  for (const v1::ExportWorldResponse& message : exported.messages) {
    EXPECT_EQ(message.world_uid(), world->uid());
    EXPECT_EQ(message.revision(), 1);
    EXPECT_EQ(message.total_bytes(), static_cast<std::int64_t>(expected.size()));
    EXPECT_EQ(message.offset(), static_cast<std::int64_t>(received.size()));
    EXPECT_LE(message.data().size(), std::size_t{kMaxChunkBytes});
    received += message.data();
    EXPECT_EQ(message.done(), &message == &exported.messages.back());
  }
  EXPECT_TRUE(received == expected);  // not EXPECT_EQ, which would print both
}

TEST_F(ExportTest, SendsFilesOneAfterTheOther) {
  PutSheets(2, Strip(50'000));
  v1::ExportWorldRequest request;
  request.set_format(v1::EXPORT_FORMAT_URDF);
  const Exported exported = Export(request);
  ASSERT_TRUE(exported.status.ok()) << exported.status.error_message();
  ASSERT_GT(exported.messages.size(), 1u);
  const auto& files = exported.messages[0].files();
  ASSERT_EQ(files.size(), 2);  // both sheets share a mesh
  EXPECT_EQ(files[0].name(), "");
  EXPECT_EQ(files[1].name(), "default_meshes/0_sheet0.stl");
  EXPECT_EQ(files[1].byte_count(), 84 + 50 * 49'998);
  EXPECT_EQ(files[0].byte_count() + files[1].byte_count(), exported.messages[0].total_bytes());
  EXPECT_EQ(exported.messages[1].files_size(), 0);
}

TEST_F(ExportTest, SaysAThousandWarningsAndHowManyMore) {
  v1::LoadRobotHeader header;
  header.set_urdf(collision::testing::Robot(collision::testing::ThreeBalls()));
  LoadRobot("r", header);
  std::vector<v1::Change> changes;
  for (int i = 0; i < 1'004; ++i) {
    const std::string name = "cup" + std::to_string(i);
    changes.push_back(PutBoxChange(name, 5));
    v1::AttachObject& attach = *changes.emplace_back().mutable_attach();
    attach.set_name(name);
    attach.set_robot("r");
    attach.set_link("e");
  }
  Apply(changes);
  const Exported exported = Export();
  ASSERT_EQ(exported.messages.size(), 1u) << exported.status.error_message();
  const auto& warnings = exported.messages[0].warnings();
  ASSERT_EQ(warnings.size(), 1'001);
  EXPECT_EQ(warnings[0], "cup0: left out, it is attached to r");
  // The warnings of 1 004 cups and of the robot.
  EXPECT_EQ(warnings[1'000], "and 5 more");
}

TEST_F(ExportTest, RefusesWhatItDoesNotKnow) {
  const std::int64_t revision = PutBox("a", 0);
  v1::ExportWorldRequest request;
  request.set_format(static_cast<v1::ExportFormat>(99));
  Exported refused = Export(request);
  EXPECT_EQ(refused.status.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(FieldIn(refused.status), "format");
  EXPECT_THAT(refused.status.error_message(), HasSubstr("is 99"));
  EXPECT_TRUE(refused.messages.empty());
  request.clear_format();
  request.set_world_uid("another");
  refused = Export(request);
  EXPECT_EQ(refused.status.error_code(), grpc::StatusCode::FAILED_PRECONDITION);
  EXPECT_EQ(ReasonIn(refused.status), "WORLD_REPLACED");
  ExpectRevision(revision);
}

TEST_F(ExportTest, RefusesMoreTrianglesThanImportReads) {
  PutSheets(3, Strip(400'000));
  const Exported refused = Export();
  EXPECT_EQ(refused.status.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_EQ(ReasonIn(refused.status), "GEOMETRY_TOO_LARGE");
  EXPECT_THAT(refused.status.error_message(), HasSubstr("at most 1000000"));
}

TEST_F(ExportTest, RefusesAMatrixOfTooManyNames) {
  std::vector<v1::Change> changes;
  PutBox("hub", 0);
  for (int i = 0; i < 2'048; ++i) {
    v1::NamedPair& pair = *changes.emplace_back().mutable_allow()->mutable_pair();
    pair.mutable_a()->set_name("hub");
    pair.mutable_b()->set_name("thing" + std::to_string(i));
  }
  Apply(changes);
  v1::ExportWorldRequest as_yaml;
  as_yaml.set_format(v1::EXPORT_FORMAT_MOVEIT_YAML);
  const Exported refused = Export(as_yaml);
  EXPECT_EQ(refused.status.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_EQ(ReasonIn(refused.status), "EXPORT_TOO_LARGE");
  EXPECT_THAT(refused.status.error_message(), HasSubstr("2049 names"));
  EXPECT_TRUE(Export().status.ok()) << "objects alone have no matrix";
}

class OneExportTest : public ExportTest {
 protected:
  static Limits OneStream() {
    Limits limits;
    limits.max_streams = 1;
    return limits;
  }
  OneExportTest() : ExportTest(OneStream()) {}
};

TEST_F(OneExportTest, CancelledInTheMiddleMakesRoomForAnother) {
  PutSheets(1, Strip(600'000));  // more than the buffers of a socket hold
  Call call;
  const auto reader = world_->ExportWorld(&call, {});
  v1::ExportWorldResponse message;
  ASSERT_TRUE(reader->Read(&message));
  EXPECT_FALSE(message.done());
  const Exported refused = Export();
  EXPECT_EQ(refused.status.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_EQ(ReasonIn(refused.status), "TOO_MANY_STREAMS");
  EXPECT_TRUE(DetailsIn(refused.status).has_retry);
  call.TryCancel();
  EXPECT_EQ(reader->Finish().error_code(), grpc::StatusCode::CANCELLED);
  // The server notices a moment later, or somewhat more on a busy machine.
  v1::ExportWorldRequest unknown;
  unknown.set_world("nobody");
  bool admitted = false;
  for (int i = 0; i < 1'000 && !admitted; ++i) {
    admitted = Export(unknown).status.error_code() == grpc::StatusCode::NOT_FOUND;
    if (!admitted) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  EXPECT_TRUE(admitted);
  ExpectRevision(1);
}

}  // namespace
}  // namespace cwm::server
