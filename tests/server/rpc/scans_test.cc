#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <set>

#include "perception/simulation/random_scenes.h"
#include "perception/simulation/virtual_scanner.h"
#include "proto/transfer/crc32c.h"
#include "tests/server/rpc/running_server.h"

namespace cwm::server {
namespace {

class ScansTest : public RunningServer {
 protected:
  using RunningServer::RunningServer;

  // Every `step`-th point of the virtual scanner's kitchen.
  static std::vector<Eigen::Vector3f> Kitchen(std::size_t step) {
    const auto scan =
        perception::Scan(perception::KitchenCounter(), perception::KitchenCamera(), {});
    std::vector<Eigen::Vector3f> points;
    for (std::size_t i = 0; i < scan.cloud.points.size(); i += step) {
      points.push_back(scan.cloud.points[i]);
    }
    return points;
  }
  v1::IngestCloudResponse MustIngest(v1::IngestCloudHeader header,
                                     const std::vector<Eigen::Vector3f>& points) {
    DescribePoints(static_cast<std::int64_t>(points.size()), &header);
    const std::string bytes(reinterpret_cast<const char*>(points.data()),
                            points.size() * sizeof(Eigen::Vector3f));
    Call call(std::chrono::minutes(5));
    v1::IngestCloudResponse response;
    const auto writer = perception_->IngestCloud(&call, &response);
    v1::IngestCloudRequest request;
    *request.mutable_header() = header;
    EXPECT_TRUE(writer->Write(request));
    constexpr std::size_t kChunk = 1 << 20;
    for (std::size_t at = 0; at < bytes.size(); at += kChunk) {
      request.mutable_chunk()->set_offset(static_cast<std::int64_t>(at));
      request.mutable_chunk()->set_data(bytes.substr(at, kChunk));
      request.mutable_chunk()->set_crc32c(Crc32c(request.chunk().data()));
      EXPECT_TRUE(writer->Write(request));
    }
    request.mutable_finish();
    EXPECT_TRUE(writer->Write(request));
    writer->WritesDone();
    const grpc::Status status = writer->Finish();
    EXPECT_TRUE(status.ok()) << status.error_message();
    return response;
  }
  grpc::Status List(const v1::ListScansRequest& request, v1::ListScansResponse* response) {
    Call call;
    response->Clear();
    return perception_->ListScans(&call, request, response);
  }
  v1::ListScansResponse MustList() {
    v1::ListScansResponse response;
    const grpc::Status status = List({}, &response);
    EXPECT_TRUE(status.ok()) << status.error_message();
    return response;
  }
  std::string Read(const std::string& hash, v1::GeometryFormat format) {
    Call call;
    v1::ReadGeometryRequest request;
    request.set_hash(hash);
    const auto reader = world_->ReadGeometry(&call, request);
    std::string bytes;
    v1::ReadGeometryResponse chunk;
    while (reader->Read(&chunk)) bytes += chunk.data();
    EXPECT_EQ(chunk.format(), format);
    return bytes;
  }
  bool IsReadable(const std::string& hash) { return application_.geometry.Get(hash).ok(); }
};

TEST_F(ScansTest, AScanIsShownAsItLiesInTheWorldWithItsLabels) {
  const auto points = Kitchen(7);
  v1::IngestCloudHeader header;
  header.set_sensor("head");
  header.mutable_frame_stamp()->set_seconds(1'700'000'000);
  header.set_want_point_labels(true);
  const v1::IngestCloudResponse ingested = MustIngest(header, points);
  const v1::ListScansResponse listed = MustList();
  EXPECT_EQ(listed.world_uid(), ingested.world_uid());
  EXPECT_EQ(listed.revision(), 1);
  ASSERT_EQ(listed.scans_size(), 1);
  const v1::Scan& scan = listed.scans(0);
  EXPECT_EQ(scan.sensor(), "head");
  EXPECT_EQ(scan.revision(), 1);
  EXPECT_EQ(scan.frame_stamp().seconds(), 1'700'000'000);
  EXPECT_EQ(scan.x_world_sensor().SerializeAsString(),
            ingested.x_world_sensor().SerializeAsString());
  EXPECT_EQ(scan.point_count(), ingested.report().points_finite());
  EXPECT_EQ(scan.kept_count(), scan.point_count());
  ASSERT_EQ(scan.supports_size(), ingested.supports_size());
  ASSERT_EQ(scan.objects_size(), ingested.objects_size());
  for (int i = 0; i < scan.objects_size(); ++i) {
    EXPECT_EQ(scan.objects(i), ingested.objects(i).name());
  }
  // The reply has a label for every point, the kept scan for every finite one.
  std::string finite_labels;
  std::size_t next = 0;
  const std::string xyz = Read(scan.points_hash(), v1::GEOMETRY_FORMAT_POINTS_F32);
  ASSERT_EQ(static_cast<std::int64_t>(xyz.size()), 12 * scan.kept_count());
  const v1::Pose& X_WC = scan.x_world_sensor();
  const Eigen::Quaterniond q_WC(X_WC.qw(), X_WC.qx(), X_WC.qy(), X_WC.qz());
  const Eigen::Vector3d p_WC(X_WC.tx_m(), X_WC.ty_m(), X_WC.tz_m());
  double worst_m = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!points[i].allFinite()) continue;
    finite_labels += ingested.labels().substr(4 * i, 4);
    Eigen::Vector3f shown;
    std::memcpy(shown.data(), xyz.data() + 12 * next++, 12);
    const Eigen::Vector3d p_WP = q_WC * points[i].cast<double>() + p_WC;
    worst_m = std::max(worst_m, (shown.cast<double>() - p_WP).norm());
  }
  constexpr double kSinglePrecision_m = 2e-6;  // at a few metres
  EXPECT_LT(worst_m, kSinglePrecision_m);
  EXPECT_TRUE(Read(scan.labels_hash(), v1::GEOMETRY_FORMAT_LABELS_U32) == finite_labels);
}

TEST_F(ScansTest, TheNewestOfEachSensorIsShown) {
  v1::IngestCloudHeader header;
  header.set_sensor("head");
  MustIngest(header, Kitchen(20));
  const v1::Scan first = MustList().scans(0);
  header.set_sensor("arm");
  header.set_mode(v1::INGEST_MODE_ADD);
  MustIngest(header, Kitchen(23));
  EXPECT_EQ(MustList().scans_size(), 2);
  header.set_sensor("head");
  MustIngest(header, Kitchen(21));
  const v1::ListScansResponse listed = MustList();
  ASSERT_EQ(listed.scans_size(), 2);
  EXPECT_EQ(listed.scans(0).sensor(), "arm");
  EXPECT_EQ(listed.scans(1).sensor(), "head");
  EXPECT_NE(listed.scans(1).points_hash(), first.points_hash());
  EXPECT_FALSE(IsReadable(first.points_hash())) << "what it replaced is let go";
}

TEST_F(ScansTest, LookingOnlyKeepsNothing) {
  PutBox("witness", 0);
  v1::IngestCloudHeader header;
  header.set_mode(v1::INGEST_MODE_SEGMENT_ONLY);
  MustIngest(header, Kitchen(20));
  EXPECT_EQ(MustList().scans_size(), 0);
}

TEST_F(ScansTest, AWorldThatIsDeletedTakesItsScansAlong) {
  MustIngest({}, Kitchen(20));
  const v1::Scan scan = MustList().scans(0);
  Call call;
  v1::DeleteWorldRequest request;
  v1::DeleteWorldResponse response;
  ASSERT_TRUE(world_->DeleteWorld(&call, request, &response).ok());
  EXPECT_FALSE(IsReadable(scan.points_hash()));
  v1::ListScansResponse listed;
  EXPECT_EQ(ReasonIn(List({}, &listed)), "WORLD_UNKNOWN");
}

TEST_F(ScansTest, AnotherWorldUnderTheNameIsSaidToBe) {
  PutBox("witness", 0);
  v1::ListScansRequest request;
  request.set_world_uid("another");
  v1::ListScansResponse listed;
  EXPECT_EQ(ReasonIn(List(request, &listed)), "WORLD_REPLACED");
}

class SmallScans : public ScansTest {
 protected:
  static Limits Small() {
    Limits limits;
    limits.max_kept_scan_points = 1'000;
    return limits;
  }
  SmallScans() : ScansTest(Small(), Retention{}) {}
};

TEST_F(SmallScans, ManyPointsAreThinned) {
  MustIngest({}, Kitchen(20));
  const v1::Scan scan = MustList().scans(0);
  EXPECT_GT(scan.point_count(), 10'000);
  EXPECT_EQ(scan.kept_count(), 1'000);
  EXPECT_EQ(Read(scan.points_hash(), v1::GEOMETRY_FORMAT_POINTS_F32).size(), 12'000U);
  EXPECT_EQ(Read(scan.labels_hash(), v1::GEOMETRY_FORMAT_LABELS_U32).size(), 4'000U);
}

}  // namespace
}  // namespace cwm::server
