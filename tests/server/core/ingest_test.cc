#include "server/core/ingest.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "server/core/error.h"
#include "tests/server/core/table_scans.h"
#include "tests/server/core/test_objects.h"

namespace cwm::server {
namespace {

using collision::ObjectState;
using collision::Revision;
using collision::WorldObjectPtr;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::UnorderedElementsAre;

class IngestTest : public ::testing::Test {
 protected:
  IngestOutcome MustIngest(const TableScan& scan, IngestMode mode = IngestMode::kUpdate) {
    IngestRequest request = RequestFor(scan);
    request.mode = mode;
    return MustIngest(request, TruthOf(scan));
  }
  IngestOutcome MustIngest(const IngestRequest& request, const Interpreter& interpret) {
    const auto outcome = Ingest(world, request, interpret, {});
    EXPECT_TRUE(outcome.ok()) << outcome.status();
    return outcome.ok() ? *outcome : IngestOutcome{};
  }
  WorldObjectPtr Get(const std::string& name) { return world.Snapshot()->Find(name); }

  World world{"w", "uid", {}};
};

TEST_F(IngestTest, TheFirstScanAddsWhatItShowsAsOneRevision) {
  const TableScan scan = ScanTable(TwoBoxes());
  const IngestOutcome outcome = MustIngest(scan);
  EXPECT_EQ(outcome.revision, Revision{1});
  EXPECT_EQ(world.Snapshot()->revision(), Revision{1});
  EXPECT_THAT(outcome.added, ElementsAre("support_1", "object_1", "object_2"));
  EXPECT_THAT(NamesIn(*world.Snapshot()), ElementsAre("object_1", "object_2", "support_1"));
  const WorldObjectPtr left = Get("object_1");
  EXPECT_EQ(left->kind, collision::ObjectKind::kObject);
  EXPECT_EQ(left->owner, collision::Owner::kPerception);
  EXPECT_EQ(left->supported_by, "support_1");
  EXPECT_EQ(left->geometry->parts.size(), 1u) << "prepared for the engines";
  EXPECT_EQ(Get("support_1")->kind, collision::ObjectKind::kSupport);
  EXPECT_TRUE(world.observations().Get("object_1").last.has_value());
}

TEST_F(IngestTest, TheOutcomeFollowsTheLabels) {
  const TableScan scan = ScanTable(TwoBoxes());
  const IngestOutcome outcome = MustIngest(scan);
  EXPECT_EQ(outcome.labels, scan.truth.labels);
  EXPECT_EQ(outcome.report.points_in, scan.cloud.size());
  EXPECT_EQ(outcome.X_WC.matrix(), scan.truth.X_WC.matrix());
  EXPECT_THAT(outcome.supports, ElementsAre(Get("support_1")));
  EXPECT_THAT(outcome.objects, ElementsAre(Get("object_1"), Get("object_2")));
  EXPECT_THAT(outcome.support_reachable, ElementsAre(true));
}

TEST_F(IngestTest, TheSameScanTwiceChangesNothing) {
  const TableScan scan = ScanTable(TwoBoxes());
  MustIngest(scan);
  const SnapshotPtr before = world.Snapshot();
  const IngestOutcome again = MustIngest(scan);
  EXPECT_EQ(world.Snapshot(), before);
  EXPECT_EQ(again.revision, Revision{1});
  EXPECT_THAT(again.kept, UnorderedElementsAre("support_1", "object_1", "object_2"));
  EXPECT_THAT(again.added, IsEmpty());
  EXPECT_THAT(again.supports, ElementsAre(Get("support_1")));
  EXPECT_THAT(again.objects, ElementsAre(Get("object_1"), Get("object_2")));
}

TEST_F(IngestTest, AKeptObjectIsObservedAgain) {
  using std::chrono::system_clock;
  const system_clock::time_point noon{std::chrono::hours(12)};
  const TableScan scan = ScanTable(TwoBoxes());
  IngestRequest request = RequestFor(scan);
  for (const auto stamp : {noon, noon + std::chrono::seconds(1)}) {
    request.frame_stamp = stamp;
    MustIngest(request, TruthOf(scan));
    EXPECT_EQ(world.observations().Get("object_2").last, stamp);
  }
  EXPECT_EQ(world.Snapshot()->revision(), Revision{1});
}

TEST_F(IngestTest, WhatMovedMovesAndTheRestIsNotTouched) {
  MustIngest(ScanTable(TwoBoxes()));
  const WorldObjectPtr left = Get("object_1");
  const WorldObjectPtr right = Get("object_2");
  const WorldObjectPtr table = Get("support_1");
  perception::SimulatedScene moved = EmptyTable();
  AddBox(moved, "left", 0, 0.2, {0.1, 0.16, 0.12});
  AddBox(moved, "right", 0.15, -0.1, {0.08, 0.08, 0.2});
  const IngestOutcome outcome = MustIngest(ScanTable(moved));
  EXPECT_THAT(outcome.moved, ElementsAre("object_2"));
  EXPECT_EQ(Get("object_1"), left);
  EXPECT_EQ(Get("support_1"), table);
  const WorldObjectPtr after = Get("object_2");
  EXPECT_EQ(after->Uid(), right->Uid());
  EXPECT_EQ(after->geometry, right->geometry) << "a move rebuilds nothing";
  EXPECT_EQ(after->geometry_revision, Revision{1});
  EXPECT_EQ(after->pose_revision, Revision{2});
  // The scanner's grid is 6 mm at this distance; the object moved by 180 mm.
  constexpr double kGrid_m = 0.01;
  EXPECT_NEAR(after->X_WO.translation().x(), 0.15, kGrid_m);
  EXPECT_NEAR(after->X_WO.translation().y(), -0.1, kGrid_m);
}

TEST_F(IngestTest, WhatRaysPassThroughGoesAndItsNameIsNotGivenAgain) {
  MustIngest(ScanTable(TwoBoxes()));
  perception::SimulatedScene one = EmptyTable();
  AddBox(one, "left", 0, 0.2, {0.1, 0.16, 0.12});
  EXPECT_THAT(MustIngest(ScanTable(one)).removed, ElementsAre("object_2"));
  EXPECT_EQ(Get("object_2"), nullptr);
  EXPECT_THAT(MustIngest(ScanTable(TwoBoxes())).added, ElementsAre("object_3"));
}

TEST_F(IngestTest, AddingRemovesAndMovesNothing) {
  MustIngest(ScanTable(TwoBoxes()));
  const SnapshotPtr before = world.Snapshot();
  perception::SimulatedScene other = EmptyTable();
  AddBox(other, "new", 0.25, 0, {0.06, 0.06, 0.06});
  const IngestOutcome outcome = MustIngest(ScanTable(other), IngestMode::kAdd);
  EXPECT_THAT(outcome.removed, IsEmpty());
  EXPECT_THAT(outcome.moved, IsEmpty());
  EXPECT_THAT(outcome.added, ElementsAre("object_3"));
  for (const WorldObjectPtr& object : before->objects()) EXPECT_EQ(Get(object->name), object);
}

TEST_F(IngestTest, WhatIsHiddenBecomesOccludedOnceAndConfirmedWhenSeen) {
  perception::SimulatedScene open = EmptyTable();
  AddBox(open, "behind", 0.2, 0, {0.06, 0.06, 0.08});
  const TableScan seen = ScanTable(open);
  MustIngest(seen);
  perception::SimulatedScene blocked = open;
  AddBox(blocked, "screen", -0.1, 0, {0.04, 0.4, 0.45});
  const TableScan hidden = ScanTable(blocked);
  const IngestOutcome outcome = MustIngest(hidden);
  EXPECT_THAT(outcome.occluded, ElementsAre("object_1"));
  EXPECT_EQ(Get("object_1")->state, ObjectState::kOccluded);
  const Revision revision = world.Snapshot()->revision();
  MustIngest(hidden);
  EXPECT_EQ(world.Snapshot()->revision(), revision) << "its state did not change again";
  MustIngest(seen);
  EXPECT_EQ(Get("object_1")->state, ObjectState::kConfirmed);
  EXPECT_EQ(Get("object_1")->pose_revision, Revision{1});
}

TEST_F(IngestTest, SegmentOnlyWritesNothing) {
  const TableScan scan = ScanTable(TwoBoxes());
  const IngestOutcome outcome = MustIngest(scan, IngestMode::kSegmentOnly);
  EXPECT_EQ(outcome.revision, Revision{0});
  EXPECT_EQ(world.Snapshot()->revision(), Revision{0});
  EXPECT_FALSE(world.SensorPoseOf("head").has_value());
  ASSERT_EQ(outcome.supports.size(), 1u);
  ASSERT_EQ(outcome.objects.size(), 2u);
  EXPECT_EQ(outcome.supports[0]->name, "support_1");
  EXPECT_EQ(outcome.objects[1]->name, "object_2");
  EXPECT_EQ(outcome.objects[1]->supported_by, "support_1");
  EXPECT_EQ(outcome.objects[1]->model().shapes.size(), 1u);
  EXPECT_EQ(outcome.labels, scan.truth.labels);
  EXPECT_THAT(MustIngest(scan).added, ElementsAre("support_1", "object_1", "object_2"))
      << "provisional names are not used up";
}

TEST_F(IngestTest, UsersObjectsAreNeverTouched) {
  // One user's box in empty space (rays pass through it), and one where "right" is.
  const perception::SimulatedScene scene = TwoBoxes();
  collision::Change right = Put("users_right");
  auto& put = std::get<collision::PutObject>(right.what);
  HybridModel model;
  model.shapes.push_back(
      {.X_OS = Pose::Identity(), .shape = scene.objects[2].parts[0].shape, .fit = {}});
  put.geometry = collision::Prepare(std::make_shared<const HybridModel>(std::move(model)));
  put.X_WO = scene.objects[2].X_WO;
  collision::Change ghost = Put("users_ghost");
  std::get<collision::PutObject>(ghost.what).X_WO = MakeTranslation(0.3, 0, 1.0);
  ASSERT_TRUE(world.Apply(std::vector{right, ghost}, {}).ok());
  const WorldObjectPtr users_right = Get("users_right");
  const WorldObjectPtr users_ghost = Get("users_ghost");

  const IngestOutcome outcome = MustIngest(ScanTable(scene));
  EXPECT_THAT(outcome.added, ElementsAre("support_1", "object_1"))
      << "what the user's box explains makes nothing";
  EXPECT_EQ(Get("users_right"), users_right);
  EXPECT_EQ(Get("users_ghost"), users_ghost);
  ASSERT_EQ(outcome.objects.size(), 2u) << "labels keep their order";
  EXPECT_EQ(outcome.objects[1]->name, "");
}

// The sensor's pose.

// Returns the truth and records the pose that it was given.
class NotingInterpreter {
 public:
  explicit NotingInterpreter(TableScan scan) : scan_(std::move(scan)) {}
  Interpreter AsFunction() {
    return [this](const perception::PointCloud&, const perception::InterpretOptions& options,
                  std::stop_token) -> absl::StatusOr<perception::SceneInterpretation> {
      given_x_m.push_back(options.X_WC ? std::optional(options.X_WC->translation().x())
                                       : std::nullopt);
      sources.push_back(options.X_WC_source);
      perception::SceneInterpretation scene = scan_.truth;
      if (options.X_WC) scene.X_WC = *options.X_WC;
      return scene;
    };
  }
  std::vector<std::optional<double>> given_x_m;
  std::vector<perception::InterpretOptions::PoseSource> sources;

 private:
  TableScan scan_;
};

Pose Turned(const Pose& X_WC, double angle_rad) {
  return Pose(Eigen::AngleAxisd(angle_rad, Vector3::UnitX())) * X_WC;
}

Vector3 UpOf(const Pose& X_WC) { return X_WC.linear().row(2).transpose(); }

TEST_F(IngestTest, TheFirstEstimateIsKeptUntilAPoseIsGiven) {
  const TableScan scan = ScanTable(TwoBoxes());
  NotingInterpreter noting(scan);
  IngestRequest request = RequestFor(scan);
  request.force = true;  // interpreted each time, though the view is the same
  request.options.X_WC.reset();
  MustIngest(request, noting.AsFunction());
  EXPECT_EQ(world.SensorPoseOf("head")->X_WC.matrix(), scan.truth.X_WC.matrix());
  MustIngest(request, noting.AsFunction());

  Pose given = scan.truth.X_WC;
  given.translation().x() += 0.001;
  request.options.X_WC = given;
  MustIngest(request, noting.AsFunction());
  request.options.X_WC.reset();
  MustIngest(request, noting.AsFunction());
  const double x_m = scan.truth.X_WC.translation().x();
  EXPECT_THAT(noting.given_x_m, ElementsAre(std::nullopt, x_m, x_m + 0.001, x_m + 0.001));

  request.sensor = "hand";
  MustIngest(request, noting.AsFunction());
  EXPECT_EQ(noting.given_x_m.back(), std::nullopt) << "each sensor has its own";
}

// From a bare wall or a single point the up direction is unknown; later scans can show it.
TEST_F(IngestTest, AGuessedPoseIsNotKept) {
  TableScan wall = ScanTable(TwoBoxes());
  wall.truth.pose_is_guess = true;
  NotingInterpreter guessing(wall);
  IngestRequest request = RequestFor(wall);
  request.options.X_WC.reset();
  MustIngest(request, guessing.AsFunction());
  EXPECT_FALSE(world.SensorPoseOf("head").has_value());
  NotingInterpreter sure(ScanTable(TwoBoxes()));
  MustIngest(request, sure.AsFunction());
  EXPECT_THAT(sure.given_x_m, ElementsAre(std::nullopt));
  EXPECT_TRUE(world.SensorPoseOf("head").has_value());
}

// An up direction that contradicts an earlier estimate comes from a user, so it causes a new
// estimate.
TEST_F(IngestTest, AnUpThatContradictsAKeptEstimateReplacesIt) {
  const TableScan scan = ScanTable(TwoBoxes());
  NotingInterpreter noting(scan);
  IngestRequest request = RequestFor(scan);
  request.options.X_WC.reset();
  const Pose estimate = Turned(scan.truth.X_WC, 0.2);  // off by more than 5 degrees
  EXPECT_TRUE(world.SetSensorPose("head", {estimate, false}).ok());
  request.options.up_C = UpOf(Turned(estimate, 0.05));  // off by less
  MustIngest(request, noting.AsFunction());
  EXPECT_EQ(world.SensorPoseOf("head")->X_WC.matrix(), estimate.matrix());
  request.options.up_C = UpOf(scan.truth.X_WC);
  MustIngest(request, noting.AsFunction());
  EXPECT_EQ(world.SensorPoseOf("head")->X_WC.matrix(), scan.truth.X_WC.matrix());
  EXPECT_FALSE(world.SensorPoseOf("head")->given);
  EXPECT_THAT(noting.given_x_m, ElementsAre(estimate.translation().x(), std::nullopt));
}

TEST_F(IngestTest, AGivenPoseRulesOverAnUp) {
  const TableScan scan = ScanTable(TwoBoxes());
  NotingInterpreter noting(scan);
  IngestRequest request = RequestFor(scan);
  MustIngest(request, noting.AsFunction());
  request.options.X_WC.reset();
  request.options.up_C = UpOf(Turned(scan.truth.X_WC, 0.2));
  MustIngest(request, noting.AsFunction());
  EXPECT_EQ(noting.given_x_m.back(), scan.truth.X_WC.translation().x());
  EXPECT_TRUE(world.SensorPoseOf("head")->given);
}

// The result of segment-only depends on no earlier scan, only on poses that were given.
TEST_F(IngestTest, SegmentOnlyUsesNoEstimateOfEarlierScans) {
  const TableScan scan = ScanTable(TwoBoxes());
  NotingInterpreter noting(scan);
  IngestRequest request = RequestFor(scan);
  request.options.X_WC.reset();
  MustIngest(request, noting.AsFunction());
  request.mode = IngestMode::kSegmentOnly;
  MustIngest(request, noting.AsFunction());
  EXPECT_EQ(noting.given_x_m.back(), std::nullopt);
  EXPECT_TRUE(world.SetSensorPose("head", {scan.truth.X_WC, true}).ok());
  MustIngest(request, noting.AsFunction());
  EXPECT_EQ(noting.given_x_m.back(), scan.truth.X_WC.translation().x());
}

// A kept estimate stays an estimate: it does not know the floor.
TEST_F(IngestTest, TheInterpreterIsToldWhetherTheKeptPoseWasGiven) {
  using Source = perception::InterpretOptions::PoseSource;
  const TableScan scan = ScanTable(TwoBoxes());
  NotingInterpreter noting(scan);
  IngestRequest request = RequestFor(scan);
  request.force = true;  // interpreted each time, though the view is the same
  request.options.X_WC.reset();
  MustIngest(request, noting.AsFunction());
  MustIngest(request, noting.AsFunction());
  request.options.X_WC = scan.truth.X_WC;
  MustIngest(request, noting.AsFunction());
  request.options.X_WC.reset();
  MustIngest(request, noting.AsFunction());
  ASSERT_EQ(noting.sources.size(), 4u);
  EXPECT_EQ(noting.sources[1], Source::kEstimated);
  EXPECT_EQ(noting.sources[2], Source::kGiven);
  EXPECT_EQ(noting.sources[3], Source::kGiven);
}

TEST_F(IngestTest, WhetherASupportIsReachableStaysKnownUntilItChanges) {
  const TableScan scan = ScanTable(TwoBoxes());
  MustIngest(scan);
  EXPECT_EQ(world.observations().Get("support_1").reachable, true);
  EXPECT_EQ(world.observations().Get("object_1").reachable, std::nullopt);
  TableScan unlogged_count = scan;
  unlogged_count.truth.supports[0].reachable = std::nullopt;
  MustIngest(unlogged_count);
  EXPECT_EQ(world.observations().Get("support_1").reachable, true) << "it is where it was";
}

TEST_F(IngestTest, ARefusedScanKeepsNoPoseAndSeesNothing) {
  const TableScan scan = ScanTable(TwoBoxes());
  TableScan bad = scan;
  // No world accepts an object beyond the largest coordinate.
  bad.truth.objects[0].X_WO.translation().x() = 1e9;
  const auto outcome = Ingest(world, RequestFor(bad), TruthOf(bad), {});
  EXPECT_EQ(outcome.status().code(), absl::StatusCode::kInvalidArgument) << outcome.status();
  EXPECT_FALSE(world.SensorPoseOf("head").has_value());
  EXPECT_FALSE(world.observations().Get("support_1").last.has_value());
}

// Two simultaneous first scans of a sensor would define two world frames.
TEST_F(IngestTest, AScanWhoseSensorGotAPoseMeanwhileIsInterpretedAnew) {
  const TableScan scan = ScanTable(TwoBoxes());
  NotingInterpreter noting(scan);
  const Interpreter inner = noting.AsFunction();
  IngestRequest request = RequestFor(scan);
  request.options.X_WC.reset();
  const auto outcome =
      Ingest(world, request,
             [&](const auto& cloud, const auto& options, std::stop_token stop) {
               auto scene = inner(cloud, options, stop);
               if (noting.given_x_m.size() == 1) {
                 EXPECT_TRUE(world.SetSensorPose("head", {scan.truth.X_WC, true}).ok());
               }
               return scene;
             },
             {});
  ASSERT_TRUE(outcome.ok()) << outcome.status();
  EXPECT_THAT(noting.given_x_m, ElementsAre(std::nullopt, scan.truth.X_WC.translation().x()));
  EXPECT_EQ(outcome->revision, Revision{1});
}

TEST_F(IngestTest, APoseThatNeverRestsAborts) {
  const TableScan scan = ScanTable(TwoBoxes());
  IngestRequest request = RequestFor(scan);
  request.options.X_WC.reset();
  double x_m = 0;
  const auto outcome =
      Ingest(world, request,
             [&](const auto&, const auto&, std::stop_token) {
               EXPECT_TRUE(world.SetSensorPose("head", {MakeTranslation(++x_m, 0, 0), true}).ok());
               return absl::StatusOr<perception::SceneInterpretation>(scan.truth);
             },
             {});
  EXPECT_EQ(outcome.status().code(), absl::StatusCode::kAborted);
  EXPECT_EQ(DetailsOf(outcome.status()).reason, "SENSOR_POSE_CHANGED");
  EXPECT_EQ(world.Snapshot()->revision(), Revision{0});
}

// Refusals.

TEST_F(IngestTest, AScanThatCannotBeInterpretedChangesNothing) {
  const TableScan scan = ScanTable(TwoBoxes());
  const auto outcome = Ingest(world, RequestFor(scan),
                              [](const auto&, const auto&, std::stop_token) {
                                return absl::StatusOr<perception::SceneInterpretation>(
                                    absl::InvalidArgumentError("cloud: has no finite point"));
                              },
                              {});
  EXPECT_EQ(outcome.status(), absl::InvalidArgumentError("cloud: has no finite point"));
  EXPECT_EQ(world.Snapshot()->revision(), Revision{0});
  EXPECT_FALSE(world.SensorPoseOf("head").has_value());
}

TEST_F(IngestTest, AStoppedScanIsCancelledBeforeItWrites) {
  const TableScan scan = ScanTable(TwoBoxes());
  std::stop_source stop;
  const auto outcome = Ingest(
      world, RequestFor(scan),
      [&](const auto&, const auto&, std::stop_token) {
        stop.request_stop();
        return absl::StatusOr<perception::SceneInterpretation>(scan.truth);
      },
      stop.get_token());
  EXPECT_EQ(outcome.status().code(), absl::StatusCode::kCancelled);
  EXPECT_EQ(world.Snapshot()->revision(), Revision{0});
}

TEST_F(IngestTest, AWorldDeletedMeanwhileRefuses) {
  const TableScan scan = ScanTable(TwoBoxes());
  const auto outcome = Ingest(world, RequestFor(scan),
                              [&](const auto&, const auto&, std::stop_token) {
                                EXPECT_TRUE(world.Close().ok());
                                return absl::StatusOr<perception::SceneInterpretation>(scan.truth);
                              },
                              {});
  EXPECT_EQ(DetailsOf(outcome.status()).reason, "WORLD_DELETED");
}

TEST_F(IngestTest, ARevisionThatDoesNotMatchIsRefusedBeforeTheWork) {
  const TableScan scan = ScanTable(TwoBoxes());
  NotingInterpreter noting(scan);
  IngestRequest request = RequestFor(scan);
  request.write.expected_revision = Revision{3};
  const auto outcome = Ingest(world, request, noting.AsFunction(), {});
  EXPECT_EQ(DetailsOf(outcome.status()).reason, "REVISION_MISMATCH");
  EXPECT_THAT(noting.given_x_m, IsEmpty());
}

TEST_F(IngestTest, ASensorsNameHasALimit) {
  IngestRequest request = RequestFor(ScanTable(EmptyTable()));
  request.sensor = std::string(129, 's');
  const auto outcome = Ingest(world, request, TruthOf(ScanTable(EmptyTable())), {});
  EXPECT_EQ(DetailsOf(outcome.status()).fields.at(0).field, "sensor");
}

// Retries.

TEST_F(IngestTest, ARetryGetsTheWholeFirstReplyWithoutTheWork) {
  const TableScan scan = ScanTable(TwoBoxes());
  NotingInterpreter noting(scan);
  IngestRequest request = RequestFor(scan);
  request.write = {.request_id = "scan 1", .request_digest = "d"};
  const IngestOutcome first = MustIngest(request, noting.AsFunction());
  ASSERT_TRUE(world.Apply(std::vector{Remove("object_1")}, {}).ok());
  const IngestOutcome retry = MustIngest(request, noting.AsFunction());
  EXPECT_EQ(noting.given_x_m.size(), 1u);
  EXPECT_EQ(world.Snapshot()->revision(), Revision{2});
  EXPECT_EQ(retry.revision, first.revision);
  EXPECT_EQ(retry.added, first.added);
  EXPECT_EQ(retry.objects, first.objects);
  EXPECT_EQ(retry.labels, first.labels);
  request.write.request_digest = "another scan";
  EXPECT_EQ(DetailsOf(Ingest(world, request, noting.AsFunction(), {}).status()).reason,
            "REQUEST_ID_REUSED");
}

TEST_F(IngestTest, RepliesAreKeptWithinTheirMemory) {
  World small("w", "uid", {.reply_bytes = 1});
  const TableScan scan = ScanTable(TwoBoxes());
  IngestRequest request = RequestFor(scan);
  request.write.request_id = "scan 1";
  ASSERT_TRUE(Ingest(small, request, TruthOf(scan), {}).ok());
  const auto retry = Ingest(small, request, TruthOf(scan), {});
  EXPECT_EQ(retry.status().code(), absl::StatusCode::kOutOfRange);
  EXPECT_EQ(DetailsOf(retry.status()).reason, "REPLY_COMPACTED");
  EXPECT_EQ(DetailsOf(retry.status()).metadata.at("revision"), "1");
}

}  // namespace
}  // namespace cwm::server
