#include "server/core/scan_plausibility.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "server/core/error.h"
#include "server/core/ingest.h"
#include "tests/server/core/table_scans.h"

namespace cwm::server {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::SizeIs;

// Boxes of different sizes, shifted by `dx_m` each.
perception::SimulatedScene ThreeBoxes(double dx_m) {
  perception::SimulatedScene scene = EmptyTable();
  AddBox(scene, "left", dx_m, 0.2, {0.1, 0.16, 0.12});
  AddBox(scene, "middle", dx_m + 0.1, 0, {0.1, 0.1, 0.06});
  AddBox(scene, "right", dx_m, -0.2, {0.08, 0.08, 0.2});
  return scene;
}

class ScanPlausibility : public ::testing::Test {
 protected:
  absl::StatusOr<IngestOutcome> Try(const TableScan& scan,
                                    const std::function<void(IngestRequest&)>& change = {}) {
    IngestRequest request = RequestFor(scan);
    if (change) change(request);
    return Ingest(world, request, TruthOf(scan), {});
  }
  // The contradiction that the refusal names; empty if the scan was taken.
  std::string Contradiction(const TableScan& scan,
                            const std::function<void(IngestRequest&)>& change = {}) {
    const collision::Revision before = world.Snapshot()->revision();
    const auto outcome = Try(scan, change);
    if (outcome.ok()) return "";
    EXPECT_EQ(world.Snapshot()->revision(), before) << "a refused scan changes nothing";
    const ErrorDetails details = DetailsOf(outcome.status());
    EXPECT_EQ(details.reason, "SCAN_CONTRADICTS_WORLD");
    return details.metadata.at("contradiction");
  }

  World world{"w", "uid", {}};
};

TableScan Raised(TableScan scan, double dz_m) {
  scan.truth.X_WC.pretranslate(Vector3(0, 0, dz_m));
  for (auto& support : scan.truth.supports) support.X_WO.pretranslate(Vector3(0, 0, dz_m));
  for (auto& object : scan.truth.objects) object.X_WO.pretranslate(Vector3(0, 0, dz_m));
  return scan;
}

TEST_F(ScanPlausibility, AScanInAnotherUnitIsRefusedWhereTheWorldHoldsSomething) {
  TableScan scan = ScanTable(ThreeBoxes(0));
  scan.truth.scale_is_implausible = true;
  EXPECT_EQ(Contradiction(scan), "") << "an empty world contradicts nothing";
  TableScan next = ScanTable(ThreeBoxes(-0.05));
  next.truth.scale_is_implausible = true;
  EXPECT_EQ(Contradiction(next), "SCALE");
  EXPECT_EQ(Contradiction(next, [](auto& request) { request.mode = IngestMode::kAdd; }), "SCALE");
  EXPECT_EQ(Contradiction(next, [](auto& request) { request.force = true; }), "");
}

TEST_F(ScanPlausibility, AScanThatTakesAllSupportsAwayIsRefused) {
  ASSERT_TRUE(Try(ScanTable(ThreeBoxes(0))).ok());
  const TableScan lowered = Raised(ScanTable(ThreeBoxes(0)), -0.3);
  EXPECT_EQ(Contradiction(lowered), "SUPPORTS_GONE");
  EXPECT_THAT(std::string(Try(lowered).status().message()), HasSubstr("set force"));
  EXPECT_EQ(Contradiction(lowered, [](auto& request) { request.force = true; }), "");
}

TEST_F(ScanPlausibility, OneMotionOfAllObjectsIsAWrongPose) {
  ASSERT_TRUE(Try(ScanTable(ThreeBoxes(0))).ok());
  EXPECT_EQ(Contradiction(ScanTable(ThreeBoxes(-0.08))), "MOVED_ALIKE");
  const auto drifted = Try(ScanTable(ThreeBoxes(-0.02)));
  ASSERT_TRUE(drifted.ok()) << drifted.status();
  EXPECT_THAT(drifted->moved, SizeIs(3));
  EXPECT_THAT(drifted->report.warnings, Contains(HasSubstr("moved alike, by 20.0 mm")));
}

TEST_F(ScanPlausibility, ObjectsMayMoveWhereOneStays) {
  ASSERT_TRUE(Try(ScanTable(ThreeBoxes(0))).ok());
  perception::SimulatedScene scene = EmptyTable();
  AddBox(scene, "left", -0.08, 0.2, {0.1, 0.16, 0.12});
  AddBox(scene, "middle", 0.1, 0, {0.1, 0.1, 0.06});
  AddBox(scene, "right", -0.08, -0.2, {0.08, 0.08, 0.2});
  EXPECT_EQ(Contradiction(ScanTable(scene)), "");
}

TEST_F(ScanPlausibility, APoseThatReplacesAnEstimateMayChangeEverything) {
  const TableScan scan = ScanTable(ThreeBoxes(0));
  ASSERT_TRUE(Try(scan, [](auto& request) { request.options.X_WC.reset(); }).ok());
  ASSERT_FALSE(world.SensorPoseOf("head")->given);
  EXPECT_EQ(Contradiction(Raised(scan, -0.3)), "");
  ASSERT_TRUE(world.SensorPoseOf("head")->given);
  EXPECT_EQ(Contradiction(Raised(scan, -0.6)), "SUPPORTS_GONE") << "the pose was given";
}

TEST_F(ScanPlausibility, PointsOfAnotherFrameDoNotLieWhereTheSensorStood) {
  const TableScan scan = ScanTable(ThreeBoxes(0));
  const auto without_pose = [](IngestRequest& request) { request.options.X_WC.reset(); };
  ASSERT_TRUE(Try(scan, without_pose).ok());
  TableScan other = Raised(ScanTable(ThreeBoxes(-0.08)), -0.7);
  other.truth.X_WC = scan.truth.X_WC;
  other.truth.seen_from_origin = false;
  EXPECT_EQ(Contradiction(other, without_pose), "VIEWPOINT");
  EXPECT_EQ(Contradiction(other), "") << "its pose is given";
}

// The frame of the points, their viewpoint and the sensor's pose.
TEST_F(ScanPlausibility, PointsOfTheWorldTellNoPoseOfASensor) {
  TableScan scan = ScanTable(ThreeBoxes(0));
  const Vector3 viewpoint = scan.truth.X_WC.translation();
  scan.truth.X_WC = MakeTranslation(viewpoint.x(), viewpoint.y(), viewpoint.z());
  for (Eigen::Vector3f& p : scan.cloud.points) {
    p = (TableCamera_X_WC().linear() * p.cast<double>()).cast<float>();
  }
  const auto outcome = Try(scan, [&](IngestRequest& request) {
    request.options.X_WC = Pose::Identity();
    request.viewpoint_C = viewpoint;
    request.in_world_frame = true;
  });
  ASSERT_TRUE(outcome.ok()) << outcome.status();
  EXPECT_TRUE(outcome->X_WC.isApprox(Pose::Identity()));
  EXPECT_FALSE(world.SensorPoseOf("head").has_value());
}

}  // namespace
}  // namespace cwm::server
