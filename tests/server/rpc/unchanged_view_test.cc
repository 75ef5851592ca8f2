// Scans of a view that did not change, interpreted by the real interpreter of a running server.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <ctime>

#include "proto/transfer/crc32c.h"
#include "tests/server/rpc/running_server.h"
#include "tests/server/rpc/simulated_depth.h"

namespace cwm::server {
namespace {

using ::testing::IsEmpty;
using ::testing::UnorderedElementsAreArray;

class UnchangedScanTest : public RunningServer {
 protected:
  struct Reply {
    v1::IngestCloudResponse response;
    double elapsed_ms = 0;  // of the call
    double cpu_ms = 0;      // of this process, client and server
  };

  v1::IngestCloudHeader Header() const {
    v1::IngestCloudHeader header;
    header.set_sensor("head");
    *header.mutable_depth() = camera_.Layout();
    header.set_total_bytes(4 * camera_.pixel_count());
    header.set_want_point_labels(true);
    return header;
  }

  Reply MustIngest(std::uint64_t frame) { return MustIngest(Header(), frame); }
  Reply MustIngest(const v1::IngestCloudHeader& header, std::uint64_t frame) {
    const std::string bytes = camera_.Frame(frame);
    const auto begin = std::chrono::steady_clock::now();
    const std::clock_t cpu_begin = std::clock();
    Reply reply;
    Call call(std::chrono::minutes(5));
    const auto writer = perception_->IngestCloud(&call, &reply.response);
    v1::IngestCloudRequest request;
    *request.mutable_header() = header;
    writer->Write(request);
    constexpr std::size_t kChunk = 1 << 20;
    for (std::size_t at = 0; at < bytes.size(); at += kChunk) {
      request.mutable_chunk()->set_offset(static_cast<std::int64_t>(at));
      request.mutable_chunk()->set_data(bytes.substr(at, kChunk));
      request.mutable_chunk()->set_crc32c(Crc32c(request.chunk().data()));
      writer->Write(request);
    }
    request.mutable_finish();
    writer->Write(request);
    writer->WritesDone();
    const grpc::Status status = writer->Finish();
    EXPECT_TRUE(status.ok()) << status.error_message();
    const std::chrono::duration<double, std::milli> elapsed =
        std::chrono::steady_clock::now() - begin;
    reply.elapsed_ms = elapsed.count();
    reply.cpu_ms = 1e3 * static_cast<double>(std::clock() - cpu_begin) / CLOCKS_PER_SEC;
    return reply;
  }

  static std::vector<std::string> NamesOf(const v1::IngestCloudResponse& response) {
    std::vector<std::string> names;
    for (const v1::Object& object : response.supports()) names.push_back(object.name());
    for (const v1::Object& object : response.objects()) names.push_back(object.name());
    return names;
  }
  static double SumOfStages_ms(const v1::IngestCloudResponse& response) {
    double sum_ms = 0;
    for (const v1::StageTime& stage : response.stages()) sum_ms += stage.elapsed_ms();
    return sum_ms;
  }
  std::vector<std::uint32_t> LabelsOf(const v1::IngestCloudResponse& response) {
    Call call;
    v1::ReadGeometryRequest read;
    read.set_hash(response.labels_hash());
    const auto reader = world_->ReadGeometry(&call, read);
    v1::ReadGeometryResponse piece;
    std::string bytes;
    while (reader->Read(&piece)) bytes += piece.data();
    std::vector<std::uint32_t> labels(bytes.size() / sizeof(std::uint32_t));
    std::memcpy(labels.data(), bytes.data(), labels.size() * sizeof(std::uint32_t));
    return labels;
  }

  SimulatedDepth camera_;
};

TEST_F(UnchangedScanTest, ASecondScanIsAnsweredByTheKnownObjects) {
  const Reply first = MustIngest(1);
  EXPECT_FALSE(first.response.report().unchanged_view());
  const std::vector<std::uint32_t> then = LabelsOf(first.response);
  int unchanged = 0;
  double cpu_ms = 0;
  constexpr int kScans = 6;
  for (int k = 0; k < kScans; ++k) {
    const Reply again = MustIngest(static_cast<std::uint64_t>(2 + k));
    EXPECT_EQ(again.response.revision(), first.response.revision());
    EXPECT_THAT(again.response.changes().added(), IsEmpty());
    if (!again.response.report().unchanged_view()) continue;
    ++unchanged;
    cpu_ms += again.cpu_ms;
    EXPECT_EQ(NamesOf(again.response), NamesOf(first.response));
    EXPECT_THAT(again.response.changes().kept(),
                UnorderedElementsAreArray(first.response.changes().added()));
    EXPECT_LT(SumOfStages_ms(again.response), again.elapsed_ms);
    const std::vector<std::uint32_t> now = LabelsOf(again.response);
    ASSERT_EQ(now.size(), then.size());
    std::int64_t labelled = 0;
    std::int64_t same = 0;
    for (std::size_t i = 0; i < now.size(); ++i) {
      if (now[i] == 0 || then[i] == 0) continue;
      ++labelled;
      same += static_cast<std::int64_t>(now[i] == then[i]);
    }
    const v1::IngestReport& report = again.response.report();
    EXPECT_GT(same, labelled - labelled / 200);
    EXPECT_GT(labelled, 9 * report.points_finite() / 10);
    EXPECT_LT(report.points_rejected(), report.points_finite() / 100);
    EXPECT_LE(report.points_explained(), report.points_finite());
  }
  ASSERT_GE(unchanged, kScans - 1);
  EXPECT_LT(5 * cpu_ms / unchanged, first.cpu_ms);
  RecordProperty("interpreted_cpu_ms", static_cast<int>(first.cpu_ms));
  RecordProperty("unchanged_cpu_ms", static_cast<int>(cpu_ms / unchanged));
}

TEST_F(UnchangedScanTest, AChangeOfTheSceneIsInterpreted) {
  MustIngest(1);
  perception::SimulatedScene scene = perception::KitchenCounter();
  auto& mug = *std::ranges::find(scene.objects, "mug", &perception::SimulatedObject::name);
  mug.X_WO.pretranslate(Vector3(0.02, 0, 0));
  camera_.Show(scene);
  EXPECT_FALSE(MustIngest(2).response.report().unchanged_view());
  EXPECT_TRUE(MustIngest(3).response.report().unchanged_view());
  camera_.Show(perception::KitchenCounter());
  EXPECT_FALSE(MustIngest(4).response.report().unchanged_view());
}

TEST_F(UnchangedScanTest, ARequestMayAskForAnInterpretation) {
  MustIngest(1);
  v1::IngestCloudHeader forced = Header();
  forced.set_force(true);
  EXPECT_FALSE(MustIngest(forced, 2).response.report().unchanged_view());
  v1::IngestCloudHeader without_cones = Header();
  without_cones.mutable_options()->set_search_cones(false);
  EXPECT_FALSE(MustIngest(without_cones, 3).response.report().unchanged_view());
}

TEST_F(UnchangedScanTest, TheKeptScanHasTheNewestStamp) {
  v1::IngestCloudHeader header = Header();
  header.mutable_frame_stamp()->set_seconds(1'700'000'000);
  MustIngest(header, 1);
  header.mutable_frame_stamp()->set_seconds(1'700'000'060);
  ASSERT_TRUE(MustIngest(header, 2).response.report().unchanged_view());
  Call call;
  v1::ListScansResponse scans;
  ASSERT_TRUE(perception_->ListScans(&call, {}, &scans).ok());
  ASSERT_EQ(scans.scans_size(), 1);
  EXPECT_EQ(scans.scans(0).frame_stamp().seconds(), 1'700'000'060);
}

}  // namespace
}  // namespace cwm::server
