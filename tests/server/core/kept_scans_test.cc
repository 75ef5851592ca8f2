#include "server/core/kept_scans.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <limits>

#include "server/core/ingest.h"
#include "tests/server/core/table_scans.h"

namespace cwm::server {
namespace {

using collision::Revision;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr std::int64_t kRoomy = 1 << 20;
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

std::vector<Eigen::Vector3f> PointsIn(const GeometryStore& store, const std::string& hash) {
  const auto blob = store.Get(hash);
  EXPECT_TRUE(blob.ok()) << blob.status();
  std::vector<Eigen::Vector3f> points((*blob)->bytes->size() / sizeof(Eigen::Vector3f));
  std::memcpy(static_cast<void*>(points.data()), (*blob)->bytes->data(), (*blob)->bytes->size());
  return points;
}

std::vector<std::uint32_t> LabelsIn(const GeometryStore& store, const std::string& hash) {
  const auto blob = store.Get(hash);
  EXPECT_TRUE(blob.ok()) << blob.status();
  std::vector<std::uint32_t> labels((*blob)->bytes->size() / sizeof(std::uint32_t));
  std::memcpy(labels.data(), (*blob)->bytes->data(), (*blob)->bytes->size());
  return labels;
}

class KeptScansTest : public ::testing::Test {
 protected:
  // The i-th of `count` points is at (i, offset, 1) and has the label i.
  KeptScan RowOf(int count, float offset = 0, std::int64_t revision = 1,
                 const std::string& sensor = "head") {
    IngestRequest request;
    request.sensor = sensor;
    IngestOutcome outcome;
    outcome.revision = Revision{revision};
    for (int i = 0; i < count; ++i) {
      request.cloud.points.emplace_back(static_cast<float>(i), offset, 1.0F);
      outcome.labels.push_back(static_cast<std::uint32_t>(i));
    }
    return MustMake(request, outcome);
  }
  KeptScan MustMake(const IngestRequest& request, const IngestOutcome& outcome) {
    auto scan = MakeKeptScan(request, outcome, limits, store);
    EXPECT_TRUE(scan.ok()) << scan.status();
    return *std::move(scan);
  }
  bool IsStored(const std::string& hash) const { return store.Get(hash).ok(); }

  Limits limits;
  GeometryStore store{kRoomy};
  KeptScans scans;
};

TEST_F(KeptScansTest, FinitePointsLieInTheWorldWithTheirLabels) {
  IngestRequest request;
  request.cloud.points = {{1, 2, 3}, {kNan, 0, 0}, {4, 5, 6}, {0, kNan, kNan}, {7, 8, 9}};
  IngestOutcome outcome;
  outcome.X_WC =
      Pose(Eigen::Translation3d(10, 20, 30) * Eigen::AngleAxisd(EIGEN_PI / 2, Vector3::UnitZ()));
  outcome.labels = {1, 0, 20, 0, 21};
  const KeptScan scan = MustMake(request, outcome);
  EXPECT_EQ(scan.point_count, 3);
  EXPECT_EQ(scan.kept_count, 3);
  const auto points = PointsIn(store, scan.points.hash);
  ASSERT_EQ(points.size(), 3u);
  // A quarter turn about z: (x, y, z) becomes (-y, x, z).
  constexpr float kSinglePrecision_m = 1e-5F;
  EXPECT_LT((points[0] - Eigen::Vector3f(8, 21, 33)).norm(), kSinglePrecision_m);
  EXPECT_LT((points[1] - Eigen::Vector3f(5, 24, 36)).norm(), kSinglePrecision_m);
  EXPECT_LT((points[2] - Eigen::Vector3f(2, 27, 39)).norm(), kSinglePrecision_m);
  EXPECT_THAT(LabelsIn(store, scan.labels.hash), ElementsAre(1, 20, 21));
}

TEST_F(KeptScansTest, WhatWasNoReturnIsNotKept) {
  IngestRequest request;
  request.cloud.points = {{0, 0, 0}, {1, 2, 3}, {0, 0, 0}};
  IngestOutcome outcome;
  outcome.labels = {0, 20, 0};
  const KeptScan scan = MustMake(request, outcome);
  EXPECT_EQ(scan.point_count, 1);
  EXPECT_THAT(LabelsIn(store, scan.labels.hash), ElementsAre(20));
}

TEST_F(KeptScansTest, NamesFollowTheLabels) {
  const TableScan table = ScanTable(TwoBoxes());
  World world("w", "uid", {});
  const auto outcome = Ingest(world, RequestFor(table), TruthOf(table), {});
  ASSERT_TRUE(outcome.ok()) << outcome.status();
  const KeptScan scan = MustMake(RequestFor(table), *outcome);
  EXPECT_EQ(scan.sensor, "head");
  EXPECT_EQ(scan.revision, Revision{1});
  EXPECT_THAT(scan.supports, ElementsAre("support_1"));
  EXPECT_THAT(scan.objects, ElementsAre("object_1", "object_2"));
}

TEST_F(KeptScansTest, TooManyPointsAreThinnedEvenly) {
  limits.max_kept_scan_points = 100;
  for (const int count : {100, 101, 150, 1'000, 1'037}) {
    const KeptScan scan = RowOf(count);
    EXPECT_EQ(scan.point_count, count);
    EXPECT_EQ(scan.kept_count, 100);
    const auto labels = LabelsIn(store, scan.labels.hash);
    ASSERT_EQ(labels.size(), 100u);
    const auto points = PointsIn(store, scan.points.hash);
    const double step = count / 100.0;
    for (std::size_t i = 0; i < labels.size(); ++i) {
      EXPECT_EQ(points[i].x(), static_cast<float>(labels[i])) << "still its own label";
      EXPECT_NEAR(labels[i], static_cast<double>(i + 1) * step - 1, 1) << count;
    }
  }
}

TEST_F(KeptScansTest, TheNewestOfASensorTakesThePlaceOfTheOneBefore) {
  scans.Keep(RowOf(3, 0, 1), limits.max_kept_scans);
  const KeptScan old = scans.List().at(0);
  EXPECT_TRUE(IsStored(old.points.hash));
  const std::string old_points = old.points.hash;
  scans.Keep(RowOf(3, 1, 2), limits.max_kept_scans);
  ASSERT_EQ(scans.List().size(), 1u);
  EXPECT_EQ(scans.List()[0].revision, Revision{2});
  EXPECT_TRUE(IsStored(old_points)) << "while somebody holds it";
}

TEST_F(KeptScansTest, WhatIsReplacedIsLetGo) {
  const std::string points = [&] {
    scans.Keep(RowOf(3, 0, 1), limits.max_kept_scans);
    return scans.List().at(0).points.hash;
  }();
  scans.Keep(RowOf(4, 1, 2), limits.max_kept_scans);
  EXPECT_FALSE(IsStored(points));
  EXPECT_TRUE(IsStored(scans.List().at(0).points.hash));
  EXPECT_TRUE(IsStored(scans.List().at(0).labels.hash));
}

TEST_F(KeptScansTest, TheSameScanAgainIsStillThere) {
  for (int revision = 1; revision <= 3; ++revision) {
    scans.Keep(RowOf(3, 0, 1), limits.max_kept_scans);
    EXPECT_TRUE(IsStored(scans.List().at(0).points.hash)) << revision;
  }
}

TEST_F(KeptScansTest, AnOlderOneComesTooLate) {
  scans.Keep(RowOf(3, 0, 5), limits.max_kept_scans);
  scans.Keep(RowOf(4, 1, 4), limits.max_kept_scans);
  EXPECT_EQ(scans.List().at(0).revision, Revision{5});
}

TEST_F(KeptScansTest, SensorsThatWereNotHeardForLongAreForgotten) {
  for (int i = 0; i < 10; ++i) scans.Keep(RowOf(3, 0, i + 1, "s" + std::to_string(i)), 3);
  std::vector<std::string> sensors;
  for (const KeptScan& scan : scans.List()) sensors.push_back(scan.sensor);
  EXPECT_THAT(sensors, ElementsAre("s7", "s8", "s9"));
}

TEST_F(KeptScansTest, WithoutRoomThereIsNone) {
  GeometryStore small(100);
  IngestRequest request;
  request.cloud.points.assign(100, Eigen::Vector3f::UnitZ());
  IngestOutcome outcome;
  outcome.labels.assign(100, 0);
  EXPECT_EQ(MakeKeptScan(request, outcome, limits, small).status().code(),
            absl::StatusCode::kResourceExhausted);
  EXPECT_THAT(scans.List(), IsEmpty());
}

}  // namespace
}  // namespace cwm::server
