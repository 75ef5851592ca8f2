#include "collision/motion/check_paths.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>
#include <random>

#include "collision/robot/kinematics.h"
#include "tests/collision/query/random_world.h"
#include "tests/collision/robot/three_ball_arm.h"

namespace cwm::collision {
namespace {

using ::testing::ElementsAre;
using testing::ThreeBallArm;

QueryBody BallBody() { return BodyFromShapes({{.X_FS = Pose::Identity(), .shape = Sphere{0.1}}}); }

// Balls of 0.1 m radius at x = 0 and x = 3.
std::shared_ptr<const WorldSnapshot> TwoBalls() {
  return WorldOf(
      {PutOf("at_0", {{.X_FS = Pose::Identity(), .shape = Sphere{0.1}}}, Pose::Identity()),
       PutOf("at_3", {{.X_FS = Pose::Identity(), .shape = Sphere{0.1}}},
             MakeTranslation(3, 0, 0))});
}

// Checks paths through places (x, y).
MotionColumns Along(const std::vector<std::pair<double, double>>& places,
                    const std::vector<Path>& paths, const QueryOptions& options = {}) {
  std::vector<Pose> poses;
  for (const auto& [x, y] : places) poses.push_back(MakeTranslation(x, y, 0));
  const QueryBody body = BallBody();
  return *CheckPaths(*TwoBalls(), body, PoseWaypoints(body, poses), paths, options);
}

TEST(CheckPaths, AreTheSameOnAnyNumberOfThreads) {
  std::mt19937 random(5);
  const auto world = RandomWorld(24, random, true);
  const QueryBody body = Gripper();
  std::vector<Pose> poses;
  for (int k = 0; k < 180; ++k) poses.push_back(RandomPose(random, 0.9));
  std::vector<Path> paths;
  for (std::size_t k = 0; k < poses.size(); k += 3) {
    paths.push_back({.first_row = k, .row_count = 3});
  }
  const PoseWaypoints waypoints(body, poses);
  const MotionColumns alone = *CheckPaths(*world, body, waypoints, paths, {});
  EXPECT_EQ(alone.completed, paths.size());
  for (const int threads : {2, 4}) {
    const MotionColumns together =
        *CheckPaths(*world, body, waypoints, paths, {.threads = threads});
    EXPECT_EQ(together.completed, alone.completed);
    EXPECT_EQ(together.verdict, alone.verdict);
    EXPECT_EQ(together.segment, alone.segment);
    EXPECT_EQ(together.lo, alone.lo);
    EXPECT_EQ(together.hi, alone.hi);
    EXPECT_EQ(together.clearance_m, alone.clearance_m);
    EXPECT_EQ(together.object, alone.object);
    EXPECT_EQ(together.body_part, alone.body_part);
    EXPECT_EQ(together.object_part, alone.object_part);
    EXPECT_EQ(together.accuracy, alone.accuracy);
  }
}

TEST(CheckPaths, OfOneEdgeAreEdges) {
  std::mt19937 random(3);
  const auto world = RandomWorld(24, random, true);
  const QueryBody body = Gripper();
  std::vector<Pose> poses;
  for (int k = 0; k < 80; ++k) poses.push_back(RandomPose(random, 0.9));
  std::vector<std::unique_ptr<BodyMotion>> edges;
  std::vector<Path> paths;
  for (std::size_t k = 0; k < poses.size(); k += 2) {
    edges.push_back(std::make_unique<RigidMotion>(body, poses[k], poses[k + 1]));
    paths.push_back({.first_row = k});
  }
  const MotionColumns by_path = *CheckPaths(*world, body, PoseWaypoints(body, poses), paths, {});
  const MotionColumns by_edge = *CheckMotions(*world, body, edges, {});
  EXPECT_EQ(by_path.verdict, by_edge.verdict);
  EXPECT_EQ(by_path.segment, by_edge.segment);
  EXPECT_EQ(by_path.lo, by_edge.lo);
  EXPECT_EQ(by_path.hi, by_edge.hi);
  EXPECT_EQ(by_path.clearance_m, by_edge.clearance_m);
  EXPECT_EQ(by_path.object, by_edge.object);
  EXPECT_EQ(by_path.object_part, by_edge.object_part);
  EXPECT_EQ(by_path.accuracy, by_edge.accuracy);
  EXPECT_EQ(by_path.completed, edges.size());
}

TEST(CheckPaths, TellTheFirstContact) {
  // Passes around the first ball, through the second, and back through the first.
  const MotionColumns columns =
      Along({{-1, 0}, {-1, 1}, {2, 1}, {2, 0}, {4, 0}, {-1, 0}}, {{.row_count = 6}});
  EXPECT_THAT(columns.verdict, ElementsAre(MotionVerdict::kContact));
  EXPECT_THAT(columns.segment, ElementsAre(3));
  EXPECT_THAT(columns.object, ElementsAre(1));
  const double truth = (1 - 0.2) / 2;  // of the two metres from x = 2 to x = 4
  EXPECT_LE(columns.lo[0], truth);
  EXPECT_GE(columns.hi[0], truth);
}

TEST(CheckPaths, AreFreeWithTheLeastClearanceOfTheirEdges) {
  const MotionColumns columns =
      Along({{-1, 1}, {-1, 0.205}, {1, 0.205}, {1, 0.21}, {-1, 0.21}, {-1, 1}}, {{.row_count = 6}});
  EXPECT_THAT(columns.verdict, ElementsAre(MotionVerdict::kFree));
  EXPECT_THAT(columns.segment, ElementsAre(-1));
  EXPECT_LE(columns.clearance_m[0], 0.005);
  EXPECT_GT(columns.clearance_m[0], 0.001);
}

TEST(CheckPaths, GrazeWhereNoLaterEdgeMeetsAnything) {
  const double grazing_m = 0.2 + 1e-7;
  const MotionColumns columns = Along({{-1, 1},
                                       {-1, grazing_m},
                                       {1, grazing_m},
                                       {1, 1},  // grazes on the second edge
                                       {-1, grazing_m},
                                       {1, grazing_m},
                                       {1, 0},
                                       {5, 0}},  // then meets the other ball
                                      {{.row_count = 4}, {.first_row = 4, .row_count = 4}});
  EXPECT_THAT(columns.verdict, ElementsAre(MotionVerdict::kGrazing, MotionVerdict::kContact));
  EXPECT_THAT(columns.segment, ElementsAre(1, 2));
  EXPECT_NEAR(columns.lo[0], 0.5, 0.01);
  EXPECT_THAT(columns.clearance_m, ElementsAre(0, 0));
}

TEST(CheckPaths, ThatTimeDoesNotSufficeForAreNotComputed) {
  QueryOptions late;
  late.deadline = std::chrono::steady_clock::now();
  const MotionColumns columns = Along({{-1, 1}, {1, 1}}, {{}}, late);
  EXPECT_EQ(columns.completed, 0u);
  EXPECT_THAT(columns.verdict, ElementsAre(MotionVerdict::kNotComputed));
  EXPECT_THAT(columns.segment, ElementsAre(-1));
}

// A path that is stopped has no answer, even if it was free so far.
TEST(CheckPaths, StopWithinALongPath) {
  const std::size_t rows = 200'000;
  std::vector<Pose> poses;
  for (std::size_t k = 0; k < rows; ++k) {
    poses.push_back(MakeTranslation(-1, 0, k % 2 == 0 ? 0.4 : 0.5));
  }
  const QueryBody body = BallBody();
  QueryOptions soon;
  soon.deadline = std::chrono::steady_clock::now() + std::chrono::milliseconds(1);
  const std::vector<Path> paths = {{.row_count = rows}};
  const MotionColumns columns =
      *CheckPaths(*TwoBalls(), body, PoseWaypoints(body, poses), paths, soon);
  EXPECT_EQ(columns.completed, 0u);
  std::stop_source stop;
  stop.request_stop();
  EXPECT_TRUE(absl::IsCancelled(
      CheckPaths(*TwoBalls(), body, PoseWaypoints(body, poses), paths, {}, stop.get_token())
          .status()));
}

TEST(CheckPaths, RefuseEnginesThatCannotCertify) {
  const QueryBody body = BallBody();
  EXPECT_TRUE(absl::IsUnimplemented(
      CheckPaths(*TwoBalls(), body, PoseWaypoints(body, {}), {}, {.engine = EngineChoice::kFcl})
          .status()));
}

class ArmPaths : public ::testing::Test {
 protected:
  void SetUp() override {
    model_ = ThreeBallArm();
    robot_ = PrepareRobot(model_, std::nullopt);
  }
  MotionColumns Check(const std::vector<double>& states, const std::vector<Path>& paths,
                      const QueryBody& body) {
    const JointRows rows(*model_, model_->all, {.base = DefaultVariables(*model_), .rows = states});
    return *CheckPaths(*world_, body, JointWaypoints(*model_, body, rows), paths, {});
  }

  std::shared_ptr<const RobotModel> model_;
  std::shared_ptr<const RobotGeometry> robot_;
  std::shared_ptr<const WorldSnapshot> world_ = WorldOf({PutOf(
      "post", {{.X_FS = Pose::Identity(), .shape = Sphere{0.1}}}, MakeTranslation(0, 1, 0))});
};

TEST_F(ArmPaths, MeetTheWorldAndThemselves) {
  const QueryBody body = BodyFromRobot(*robot_, RobotScope::kBoth);
  // The first path is free; the second goes through the post at pi / 2; the third bends until the
  // hand meets the base.
  const std::vector<double> states = {0, 0, 1, 0, 0, 0, 1, 0, 2, 0, 0, 0, 0, 3};
  const MotionColumns columns =
      Check(states, {{}, {.first_row = 2, .row_count = 3}, {.first_row = 5}}, body);
  EXPECT_THAT(columns.verdict,
              ElementsAre(MotionVerdict::kFree, MotionVerdict::kContact, MotionVerdict::kContact));
  EXPECT_THAT(columns.segment, ElementsAre(-1, 1, 0));
  EXPECT_THAT(columns.object, ElementsAre(-1, 0, kSelfObject));
  EXPECT_LT(columns.hi[1] + 1, std::numbers::pi / 2);
}

TEST_F(ArmPaths, AreOutOfLimitsFirstOfAll) {
  const QueryBody body = BodyFromRobot(*robot_, RobotScope::kBoth);
  // The first row is in contact; the third is outside the limits.
  const std::vector<double> states = {1.57, 0, 1.6, 0, 3.1, 0, 3.2, 0};
  const MotionColumns columns = Check(states, {{.row_count = 4}, {}}, body);
  EXPECT_THAT(columns.verdict, ElementsAre(MotionVerdict::kOutOfLimits, MotionVerdict::kContact));
  EXPECT_THAT(columns.segment, ElementsAre(2, 0));
  EXPECT_THAT(columns.object, ElementsAre(-1, 0));
}

// The bounds of a motion use the parts of the body that moves: far spheres travel far.
TEST_F(ArmPaths, OfSpheresAreThoseOfTheSpheres) {
  SphereModel spheres;
  spheres.links.resize(model_->links.size());
  spheres.links[static_cast<std::size_t>(*model_->FindLink("e"))] = {
      {.center_L = {1, 0, 0}, .radius_m = 0.01}};
  const QueryBody body = BodyFromSpheres(*robot_, spheres, RobotScope::kBoth);
  world_ = WorldOf({PutOf("far", {{.X_FS = Pose::Identity(), .shape = Sphere{0.01}}},
                          MakeTranslation(0, 2, 0))});
  const std::vector<double> states = {1, 0, 2, 0};
  EXPECT_THAT(Check(states, {{}}, body).verdict, ElementsAre(MotionVerdict::kContact));
  EXPECT_THAT(Check(states, {{}}, BodyFromRobot(*robot_, RobotScope::kBoth)).verdict,
              ElementsAre(MotionVerdict::kFree));
}

}  // namespace
}  // namespace cwm::collision
