#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <limits>
#include <semaphore>
#include <thread>

#include "perception/simulation/random_scenes.h"
#include "perception/simulation/virtual_scanner.h"
#include "proto/transfer/crc32c.h"
#include "server/core/geometry_store.h"
#include "tests/server/rpc/running_server.h"

namespace cwm::server {
namespace {

using ::testing::HasSubstr;

perception::SimulatedCloud Scan() {
  return perception::Scan(perception::KitchenCounter(), perception::KitchenCamera(), {});
}

class PerceptionTest : public RunningServer {
 protected:
  using Messages = std::vector<v1::IngestCloudRequest>;

  static v1::IngestCloudHeader HeaderFor(const std::vector<Eigen::Vector3f>& points) {
    v1::IngestCloudHeader header;
    DescribePoints(static_cast<std::int64_t>(points.size()), &header);
    return header;
  }
  static std::string BytesOf(const std::vector<Eigen::Vector3f>& points) {
    return std::string(reinterpret_cast<const char*>(points.data()),
                       points.size() * sizeof(Eigen::Vector3f));
  }
  static v1::IngestCloudRequest ChunkOf(const std::string& bytes, std::size_t offset,
                                        std::size_t size) {
    v1::IngestCloudRequest request;
    v1::CloudChunk* chunk = request.mutable_chunk();
    chunk->set_offset(static_cast<std::int64_t>(offset));
    chunk->set_data(bytes.substr(offset, size));
    chunk->set_crc32c(Crc32c(chunk->data()));
    return request;
  }
  // Header, chunks and finish of a valid upload.
  static Messages Upload(const v1::IngestCloudHeader& header, const std::string& bytes,
                         std::size_t chunk_bytes = 1 << 20) {
    Messages messages(1);
    *messages[0].mutable_header() = header;
    for (std::size_t at = 0; at < bytes.size(); at += chunk_bytes) {
      messages.push_back(ChunkOf(bytes, at, chunk_bytes));
    }
    messages.emplace_back().mutable_finish();
    return messages;
  }
  // An upload of three chunks, to be corrupted by tests.
  static Messages SmallUpload() {
    const std::vector<Eigen::Vector3f> points(30, Eigen::Vector3f(0, 0, 1));
    return Upload(HeaderFor(points), BytesOf(points), 120);
  }
  grpc::Status Send(const Messages& messages, v1::IngestCloudResponse* response = nullptr) {
    Call call(std::chrono::minutes(5));
    v1::IngestCloudResponse ignored;
    const auto writer = perception_->IngestCloud(&call, response != nullptr ? response : &ignored);
    for (const v1::IngestCloudRequest& message : messages) {
      if (!writer->Write(message)) break;
    }
    writer->WritesDone();
    return writer->Finish();
  }
  grpc::Status SegmentOnly(v1::IngestCloudResponse* response) {
    const auto scan = Scan();
    v1::IngestCloudHeader header = HeaderFor(scan.cloud.points);
    header.set_width(scan.cloud.width);
    header.set_height(scan.cloud.height);
    header.set_mode(v1::INGEST_MODE_SEGMENT_ONLY);
    return Send(Upload(header, BytesOf(scan.cloud.points)), response);
  }
  // The size of a blob; 0 if there is no such blob.
  std::int64_t BytesOfBlob(const std::string& hash) {
    Call call;
    v1::ReadGeometryRequest read;
    read.set_hash(hash);
    const auto reader = world_->ReadGeometry(&call, read);
    v1::ReadGeometryResponse piece;
    std::int64_t bytes = 0;
    while (reader->Read(&piece)) bytes += static_cast<std::int64_t>(piece.data().size());
    return bytes;
  }
  // Expects the small box that a hostile client must not change.
  void ExpectUntouched() { ExpectRevision(1); }
};

TEST_F(PerceptionTest, AScanBecomesSupportsAndObjectsAndTheSameScanChangesNothing) {
  const auto scan = Scan();
  v1::IngestCloudHeader header = HeaderFor(scan.cloud.points);
  header.set_width(scan.cloud.width);
  header.set_height(scan.cloud.height);
  header.set_want_point_labels(true);
  header.set_sensor("head");
  const std::string bytes = BytesOf(scan.cloud.points);
  v1::IngestCloudResponse response;
  auto status = Send(Upload(header, bytes), &response);
  ASSERT_TRUE(status.ok()) << status.error_message();
  EXPECT_EQ(response.revision(), 1);
  EXPECT_GE(response.supports_size(), 1);
  EXPECT_GE(response.objects_size(), 3);
  EXPECT_EQ(response.report().points_in(), 640 * 480);
  EXPECT_FALSE(response.changes().added().empty());
  EXPECT_GT(response.stages_size(), 0);
  // 640 x 480 labels are larger than a mebibyte, so they are sent by hash.
  EXPECT_EQ(BytesOfBlob(response.labels_hash()), 4 * 640 * 480);
  status = Send(Upload(header, bytes), &response);
  ASSERT_TRUE(status.ok()) << status.error_message();
  EXPECT_EQ(response.revision(), 1) << "the same scan makes no revision";
}

TEST_F(PerceptionTest, SegmentOnlyMakesNoRevision) {
  v1::IngestCloudResponse response;
  const auto status = SegmentOnly(&response);
  ASSERT_TRUE(status.ok()) << status.error_message();
  EXPECT_EQ(response.revision(), 0);
  EXPECT_GE(response.objects_size(), 1);
}

TEST_F(PerceptionTest, SegmentOnlyNamesMeshesThatCanStillBeRead) {
  v1::IngestCloudResponse response;
  const auto status = SegmentOnly(&response);
  ASSERT_TRUE(status.ok()) << status.error_message();
  int meshes = 0;
  for (const v1::Object& object : response.objects()) {
    for (const v1::SurfacePart& surface : object.surfaces()) {
      ++meshes;
      EXPECT_EQ(BytesOfBlob(surface.hash()),
                8 + 24 * surface.vertex_count() + 12 * surface.triangle_count())
          << object.name();
    }
    for (const v1::Handle& handle : object.handles()) {
      if (handle.hash().empty()) continue;
      ++meshes;
      EXPECT_GT(BytesOfBlob(handle.hash()), 0) << object.name();
    }
  }
  EXPECT_GE(meshes, 1) << "else nothing is tested";
}

TEST_F(PerceptionTest, UploadsOutOfOrderAreRefusedAndLeaveNothing) {
  PutBox("witness", 0);
  struct Case {
    std::string what;
    std::function<void(Messages&)> spoil;
    std::string field;
  };
  const std::vector<Case> cases = {
      {"out of order", [](auto& m) { std::swap(m[1], m[2]); }, "chunk.offset"},
      {"missing", [](auto& m) { m.erase(m.begin() + 2); }, "chunk.offset"},
      {"last missing", [](auto& m) { m.erase(m.begin() + 3); }, "finish"},
      {"twice", [](auto& m) { m.insert(m.begin() + 2, m[1]); }, "chunk.offset"},
      {"after the end", [](auto& m) { m.push_back(m[3]); }, "what"},
      {"beyond the end",
       [](auto& m) {
         m.insert(m.begin() + 4, m[3]);
         m[4].mutable_chunk()->set_offset(360);
       },
       "chunk.data"},
      {"no header", [](auto& m) { m.erase(m.begin()); }, "chunk"},
      {"two headers", [](auto& m) { m.insert(m.begin(), m[0]); }, "header"},
      {"no finish", [](auto& m) { m.pop_back(); }, "finish"},
      {"nothing at all", [](auto& m) { m.clear(); }, "header"},
      {"an empty message", [](auto& m) { m.insert(m.begin() + 1, v1::IngestCloudRequest()); },
       "what"},
      {"an empty chunk", [](auto& m) { m[1].mutable_chunk()->clear_data(); }, "chunk.data"},
      {"a bit flipped", [](auto& m) { (*m[2].mutable_chunk()->mutable_data())[5] ^= 1; },
       "chunk.crc32c"},
      {"another digest", [](auto& m) { m[4].mutable_finish()->set_sha256("abc"); },
       "finish.sha256"},
      {"a negative offset", [](auto& m) { m[1].mutable_chunk()->set_offset(-1); }, "chunk.offset"},
  };
  for (const Case& c : cases) {
    Messages messages = SmallUpload();
    c.spoil(messages);
    const grpc::Status status = Send(messages);
    EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT) << c.what;
    EXPECT_EQ(FieldIn(status), c.field) << c.what << ": " << status.error_message();
  }
  ExpectUntouched();
}

TEST_F(PerceptionTest, ACloudOverTheLimitIsRefusedOnItsHeader) {
  PutBox("witness", 0);
  Call call;
  v1::IngestCloudResponse response;
  const auto writer = perception_->IngestCloud(&call, &response);
  v1::IngestCloudRequest request;
  *request.mutable_header() = HeaderFor({});
  request.mutable_header()->set_point_count(20'000'001);
  request.mutable_header()->set_total_bytes(12 * std::int64_t{20'000'001});
  ASSERT_TRUE(writer->Write(request));
  // No data and no half-close: the answer comes after the header alone.
  const grpc::Status status = writer->Finish();
  EXPECT_EQ(FieldIn(status), "header.point_count");
  EXPECT_THAT(status.error_message(), HasSubstr("must be from 1 to 20000000"));
  ExpectUntouched();
}

TEST_F(PerceptionTest, AClientThatGoesHalfWayLeavesNothing) {
  PutBox("witness", 0);
  const Messages small = SmallUpload();
  // Each announces 240 MB: nine of them exceed what all uploads together may hold.
  v1::IngestCloudRequest header;
  *header.mutable_header() = HeaderFor({});
  header.mutable_header()->set_point_count(20'000'000);
  header.mutable_header()->set_total_bytes(12 * std::int64_t{20'000'000});
  for (int round = 0; round < 12; ++round) {
    Call call;
    v1::IngestCloudResponse response;
    const auto writer = perception_->IngestCloud(&call, &response);
    ASSERT_TRUE(writer->Write(header));
    ASSERT_TRUE(writer->Write(small[1]));
    call.TryCancel();
    EXPECT_EQ(writer->Finish().error_code(), grpc::StatusCode::CANCELLED);
  }
  ExpectUntouched();
  // Their memory is free again soon: the next one is refused only for its own error.
  grpc::StatusCode code = grpc::StatusCode::RESOURCE_EXHAUSTED;
  for (int i = 0; i < 100 && code == grpc::StatusCode::RESOURCE_EXHAUSTED; ++i) {
    Call call;
    v1::IngestCloudResponse response;
    const auto writer = perception_->IngestCloud(&call, &response);
    writer->Write(header);
    writer->WritesDone();
    code = writer->Finish().error_code();
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  EXPECT_EQ(code, grpc::StatusCode::INVALID_ARGUMENT);
}

TEST_F(PerceptionTest, CloudsWithoutSenseAreRefusedAndTheServerGoesOn) {
  PutBox("witness", 0);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const std::vector<std::vector<Eigen::Vector3f>> clouds = {
      {},
      std::vector<Eigen::Vector3f>(1'000, Eigen::Vector3f(nan, nan, nan)),
      std::vector<Eigen::Vector3f>(1'000, Eigen::Vector3f(1e30f, 0, 1)),
  };
  const std::vector<std::string> fields = {"header.point_count", "chunk.data", "point 0.x"};
  for (std::size_t i = 0; i < clouds.size(); ++i) {
    const grpc::Status status = Send(Upload(HeaderFor(clouds[i]), BytesOf(clouds[i])));
    EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT)
        << clouds[i].size() << " points: " << status.error_message();
    EXPECT_EQ(FieldIn(status), fields[i]) << status.error_message();
  }
  ExpectUntouched();
}

TEST_F(PerceptionTest, FewAndEqualPointsDoNoHarm) {
  for (const std::size_t count : {1, 1'000}) {
    const std::vector<Eigen::Vector3f> points(count, Eigen::Vector3f(0.1f, 0.2f, 1));
    v1::IngestCloudResponse response;
    const grpc::Status status = Send(Upload(HeaderFor(points), BytesOf(points)), &response);
    ASSERT_TRUE(status.ok()) << status.error_message();
    const auto points_in = static_cast<std::int64_t>(count);
    EXPECT_EQ(response.report().points_in(), points_in);
    EXPECT_EQ(response.report().points_finite(), points_in);
    EXPECT_EQ(response.supports_size(), 0);
    EXPECT_THAT(response.report().warnings(),
                ::testing::Contains("no support found: all points are residual geometry"));
  }
}

TEST_F(PerceptionTest, ARetryOfAnIngestGetsTheFirstReply) {
  const auto scan = Scan();
  v1::IngestCloudHeader header = HeaderFor(scan.cloud.points);
  header.set_request_id("scan-1");
  v1::IngestCloudResponse first;
  v1::IngestCloudResponse second;
  const auto upload = Upload(header, BytesOf(scan.cloud.points));
  ASSERT_TRUE(Send(upload, &first).ok());
  PutBox("between", 3);
  ASSERT_TRUE(Send(upload, &second).ok());
  EXPECT_EQ(second.revision(), first.revision());
  EXPECT_EQ(second.objects_size(), first.objects_size());
  auto other = scan.cloud.points;
  other[0].x() += 1;
  EXPECT_EQ(ReasonIn(Send(Upload(header, BytesOf(other)))), "REQUEST_ID_REUSED");
}

TEST_F(PerceptionTest, ATimeBudgetThatIsSpentEndsTheWorkAndLeavesNothing) {
  PutBox("witness", 0);
  const auto scan = Scan();
  v1::IngestCloudHeader header = HeaderFor(scan.cloud.points);
  header.mutable_time_budget()->set_nanos(1'000'000);
  const grpc::Status status = Send(Upload(header, BytesOf(scan.cloud.points)));
  EXPECT_EQ(status.error_code(), grpc::StatusCode::DEADLINE_EXCEEDED);
  EXPECT_EQ(ReasonIn(status), "TIME_BUDGET_SPENT");
  ExpectUntouched();
}

v1::ListWorldsResponse Worlds(v1::WorldService::Stub& stub) {
  Call call;
  v1::ListWorldsResponse worlds;
  EXPECT_TRUE(stub.ListWorlds(&call, {}, &worlds).ok());
  return worlds;
}

TEST_F(PerceptionTest, OnlyAScanThatIsWrittenMakesAWorld) {
  const auto scan = Scan();
  const std::string bytes = BytesOf(scan.cloud.points);
  v1::IngestCloudHeader header = HeaderFor(scan.cloud.points);
  header.set_mode(v1::INGEST_MODE_SEGMENT_ONLY);
  v1::IngestCloudResponse response;
  ASSERT_TRUE(Send(Upload(header, bytes), &response).ok());
  EXPECT_EQ(response.world_uid(), "");
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const std::vector<Eigen::Vector3f> nothing(100, Eigen::Vector3f(nan, nan, nan));
  EXPECT_FALSE(Send(Upload(HeaderFor(nothing), BytesOf(nothing))).ok());
  header.clear_mode();
  header.set_expected_revision(3);
  EXPECT_EQ(ReasonIn(Send(Upload(header, bytes))), "REVISION_MISMATCH");
  header.set_world_uid("another");
  EXPECT_EQ(ReasonIn(Send(Upload(header, bytes))), "WORLD_UNKNOWN");
  EXPECT_EQ(Worlds(*world_).worlds_size(), 0);
  header.clear_world_uid();
  header.set_expected_revision(0);
  ASSERT_TRUE(Send(Upload(header, bytes), &response).ok());
  ASSERT_EQ(Worlds(*world_).worlds_size(), 1);
  EXPECT_EQ(Worlds(*world_).worlds(0).world_uid(), response.world_uid());
}

// The meshes of provisional objects are freed with them, except for those named in the reply:
// surfaces, and the walls of vessels.
TEST_F(PerceptionTest, EveryMeshThatAProvisionalReplyNamesCanBeRead) {
  const perception::SimulatedView view =
      perception::RandomScene(perception::SceneFamily::kVessels, 1);
  const auto scan = perception::Scan(view.scene, view.camera, {.seed = 1});
  v1::IngestCloudHeader header = HeaderFor(scan.cloud.points);
  header.set_width(scan.cloud.width);
  header.set_height(scan.cloud.height);
  header.set_mode(v1::INGEST_MODE_SEGMENT_ONLY);
  v1::IngestCloudResponse response;
  ASSERT_TRUE(Send(Upload(header, BytesOf(scan.cloud.points)), &response).ok());
  std::vector<std::string> shells, surfaces;
  for (const v1::Object& object : response.objects()) {
    for (const v1::ShapePart& part : object.shapes()) {
      if (part.has_mesh()) shells.push_back(part.mesh().hash());
    }
    for (const v1::SurfacePart& part : object.surfaces()) surfaces.push_back(part.hash());
  }
  EXPECT_FALSE(shells.empty());
  EXPECT_FALSE(surfaces.empty());
  surfaces.insert(surfaces.end(), shells.begin(), shells.end());
  for (const std::string& hash : surfaces) {
    Call call;
    v1::ReadGeometryRequest request;
    request.set_hash(hash);
    const auto reader = world_->ReadGeometry(&call, request);
    v1::ReadGeometryResponse part;
    EXPECT_TRUE(reader->Read(&part)) << hash;
    while (reader->Read(&part)) {
    }
    EXPECT_TRUE(reader->Finish().ok()) << hash;
  }
}

// Reachability is known only if the floor is known, which an estimated pose does not provide.
TEST_F(PerceptionTest, SupportsAreReachableOrNotOnceThePoseWasGivenWhereverTheyAreShown) {
  const auto scan = Scan();
  const std::string bytes = BytesOf(scan.cloud.points);
  v1::IngestCloudHeader header = HeaderFor(scan.cloud.points);
  header.set_width(scan.cloud.width);
  header.set_height(scan.cloud.height);
  header.set_sensor("head");
  const auto supports = [this](const std::string& world) {
    Call call;
    v1::ListObjectsRequest request;
    request.set_world(world);
    request.add_kinds(v1::OBJECT_KIND_SUPPORT);
    v1::ListObjectsResponse response;
    EXPECT_TRUE(world_->ListObjects(&call, request, &response).ok());
    EXPECT_GT(response.objects_size(), 0);
    return response.objects();
  };
  header.set_world("estimated");
  for (int i = 0; i < 2; ++i) {  // the second scan reuses the estimate of the first
    ASSERT_TRUE(Send(Upload(header, bytes)).ok());
    for (const v1::Object& support : supports("estimated")) {
      EXPECT_FALSE(support.has_reachable()) << support.name();
    }
  }
  header.set_world("given");
  const Pose X_WC = perception::KitchenCamera().X_WC;
  const Eigen::Quaterniond q(X_WC.linear());
  v1::Pose* pose = header.mutable_x_world_sensor();
  pose->set_tx_m(X_WC.translation().x());
  pose->set_ty_m(X_WC.translation().y());
  pose->set_tz_m(X_WC.translation().z());
  pose->set_qx(q.x());
  pose->set_qy(q.y());
  pose->set_qz(q.z());
  pose->set_qw(q.w());
  ASSERT_TRUE(Send(Upload(header, bytes)).ok());
  header.clear_x_world_sensor();  // the pose is kept, and known to be given
  ASSERT_TRUE(Send(Upload(header, bytes)).ok());
  v1::WatchWorldRequest watch_request;
  watch_request.set_world("given");
  Call watch_call;
  const auto watch = world_->WatchWorld(&watch_call, watch_request);
  v1::WatchWorldResponse initial;
  ASSERT_TRUE(watch->Read(&initial));
  int shown = 0;
  for (const v1::Object& object : initial.initial_state().objects()) {
    EXPECT_EQ(object.has_reachable(), object.kind() == v1::OBJECT_KIND_SUPPORT) << object.name();
    shown += object.has_reachable();
  }
  EXPECT_GT(shown, 0);
  watch_call.TryCancel();
  for (const v1::Object& support : supports("given")) {
    EXPECT_TRUE(support.has_reachable()) << support.name();
    Call call;
    v1::GetObjectRequest request;
    request.set_world("given");
    request.set_name(support.name());
    v1::GetObjectResponse got;
    ASSERT_TRUE(world_->GetObject(&call, request, &got).ok());
    EXPECT_EQ(got.object().reachable(), support.reachable());
  }
}

TEST_F(PerceptionTest, ADeadlineEndsTheWorkBeforeItStrikes) {
  std::atomic<bool> stopped = false;
  application_.interpret = [&](const auto&, const auto&, std::stop_token stop) {
    while (!stop.stop_requested()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    stopped = true;
    return absl::StatusOr<perception::SceneInterpretation>(absl::CancelledError("stopped"));
  };
  // A tenth of the deadline is left for the reply.
  Call call(std::chrono::seconds(2));
  v1::IngestCloudResponse response;
  const auto writer = perception_->IngestCloud(&call, &response);
  for (const v1::IngestCloudRequest& message : SmallUpload()) ASSERT_TRUE(writer->Write(message));
  writer->WritesDone();
  const grpc::Status status = writer->Finish();
  EXPECT_TRUE(stopped);
  EXPECT_EQ(status.error_code(), grpc::StatusCode::DEADLINE_EXCEEDED);
  // From the server: gRPC's own DEADLINE_EXCEEDED would carry no reason.
  EXPECT_EQ(ReasonIn(status), "TIME_BUDGET_SPENT");
}

TEST_F(PerceptionTest, AFullQueueOfCloudsSaysWhenToComeBackAndQueriesGoOn) {
  PutBox("witness", 0);
  std::counting_semaphore<> finish{0};
  application_.interpret = [&](const auto&, const auto&, std::stop_token) {
    finish.acquire();
    return absl::StatusOr<perception::SceneInterpretation>(absl::InvalidArgumentError("no"));
  };
  constexpr int kMax = 100;  // more than the queue and its thread can hold
  std::atomic<int> refused = 0;
  std::vector<std::jthread> senders;
  for (int i = 0; i < kMax && refused == 0; ++i) {
    senders.emplace_back([&] {
      const grpc::Status status = Send(SmallUpload());
      if (status.error_code() == grpc::StatusCode::INVALID_ARGUMENT) return;  // its turn came
      EXPECT_EQ(status.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
      EXPECT_EQ(ReasonIn(status), "QUEUE_FULL");
      EXPECT_TRUE(DetailsIn(status).has_retry);
      ++refused;
    });
    v1::GetDistancesRequest request;
    *request.mutable_subject() = SphereAt({0.5});
    Call call;
    v1::GetDistancesResponse response;
    EXPECT_TRUE(query_->GetDistances(&call, request, &response).ok());
  }
  finish.release(kMax);
  senders.clear();  // joins
  EXPECT_GT(refused, 0);
  ExpectUntouched();
}

}  // namespace
}  // namespace cwm::server
