#include "collision/inverse_kinematics/solve_poses.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "collision/robot/kinematics.h"
#include "tests/collision/inverse_kinematics/planar_arm.h"
#include "tests/collision/query/random_world.h"

namespace cwm::collision {
namespace {

using ::testing::DoubleNear;
using ::testing::Each;
using ::testing::ElementsAre;
using testing::kQuarter;
using testing::Planar;
using testing::PlanarArm;
using testing::WristAt;

// A planar arm whose elbow, a ball, is at (0.5, 0) or (0, 0.5) if the wrist is at (0.5, 0.5).
class ArmAmongBalls : public ::testing::Test {
 protected:
  // Balls at elbows of the two solutions.
  static std::shared_ptr<const WorldSnapshot> WorldWith(bool at_first, bool at_second) {
    std::vector<Change> changes;
    const auto put = [&](const std::string& name, double x_m, double y_m) {
      changes.push_back(PutOf(name, {{.shape = Sphere{0.05}}}, MakeTranslation(x_m, y_m, 0)));
    };
    if (at_first) put("first", 0.5, 0);
    if (at_second) put("second", 0, 0.5);
    put("far", 9, 9);
    return WorldOf(changes);
  }

  PoseColumns Solve(const WorldSnapshot& world, PoseBatch batch, int threads = 1,
                    const std::string& limit = "3.1") {
    const auto model = testing::ModelOf(PlanarArm(limit));
    const auto robot = PrepareRobot(model, std::nullopt);
    const JointRows states(*model, model->all, {.base = DefaultVariables(*model)});
    auto chain = MakeIkChain(*model, model->all, DefaultVariables(*model), *model->FindLink("e"),
                             Pose::Identity());
    EXPECT_TRUE(chain.ok()) << chain.status();
    QueryOptions options;
    options.threads = threads;
    auto columns =
        SolvePoses(world, BodyFromRobot(*robot, RobotScope::kBoth), *chain, states, batch, options);
    EXPECT_TRUE(columns.ok()) << columns.status();
    return *std::move(columns);
  }

  const std::vector<Pose> at_wrist_ = {WristAt(0.5, 0.5, kQuarter)};
  const std::vector<double> seed_ = {0.1, 1.4, 0.1};  // near (0, pi / 2, 0)
};

TEST_F(ArmAmongBalls, AnswersOnePoseByTheSolutionNearestToTheSeed) {
  const auto world = WorldWith(false, false);
  const PoseColumns columns = Solve(*world, {.X_WT = at_wrist_, .seeds = seed_});
  EXPECT_THAT(columns.status, ElementsAre(PoseStatus::kSolved));
  EXPECT_THAT(columns.row_begin, ElementsAre(0, 1));
  EXPECT_THAT(columns.rows,
              ElementsAre(DoubleNear(0, 1e-6), DoubleNear(kQuarter, 1e-6), DoubleNear(0, 1e-6)));
}

TEST_F(ArmAmongBalls, AvoidsASolutionThatCollides) {
  const auto world = WorldWith(true, false);
  const PoseColumns columns =
      Solve(*world, {.X_WT = at_wrist_, .seeds = seed_, .avoid_collision = true});
  EXPECT_THAT(columns.status, ElementsAre(PoseStatus::kSolved));
  EXPECT_THAT(columns.rows, ElementsAre(DoubleNear(kQuarter, 1e-6), DoubleNear(-kQuarter, 1e-6),
                                        DoubleNear(kQuarter, 1e-6)));
}

TEST_F(ArmAmongBalls, TellsThatAllSolutionsCollide) {
  const auto world = WorldWith(true, true);
  const PoseColumns columns =
      Solve(*world, {.X_WT = at_wrist_, .seeds = seed_, .avoid_collision = true});
  EXPECT_THAT(columns.status, ElementsAre(PoseStatus::kInCollision));
  EXPECT_NEAR(columns.rows.at(1), kQuarter, 1e-6) << "the solution nearest to the seed";
}

TEST_F(ArmAmongBalls, OnTheBranchOfTheSeedThereIsNoOtherSolution) {
  const auto world = WorldWith(true, false);
  const PoseColumns columns = Solve(
      *world, {.X_WT = at_wrist_, .seeds = seed_, .same_branch = true, .avoid_collision = true});
  EXPECT_THAT(columns.status, ElementsAre(PoseStatus::kInCollision));
}

TEST_F(ArmAmongBalls, TellsLimitsFromReach) {
  const auto world = WorldWith(false, false);
  const std::vector<Pose> poses = {WristAt(-0.9, 0, 2 * kQuarter), Planar(3, 0, 0)};
  const std::vector<double> seed = {0, 0, 0};
  const PoseColumns columns =
      Solve(*world, {.X_WT = poses, .seeds = seed, .max_steps = 300}, 1, "1.6");
  EXPECT_THAT(columns.status, ElementsAre(PoseStatus::kOutOfLimits, PoseStatus::kUnreachable));
  EXPECT_THAT(columns.row_begin, ElementsAre(0, 1, 2)) << "one row each, of what was met";
  EXPECT_LT(columns.position_error_m[0], 1e-5);
  EXPECT_NEAR(columns.position_error_m[1], 1.8, 3e-3);
}

TEST_F(ArmAmongBalls, PlacesTheBaseAndTakesASeedForEachPose) {
  const auto world = WorldWith(false, false);
  Pose X_WB = MakeTranslation(1, 2, 0.5);
  X_WB.rotate(Eigen::AngleAxisd(1.0, Vector3::UnitZ()));
  const Pose X_WT = X_WB * WristAt(0.5, 0.5, kQuarter);
  const std::vector<Pose> poses = {X_WT, X_WT};
  const std::vector<double> seeds = {0.1, 1.4, 0.1, 1.4, -1.4, 1.4};
  const PoseColumns columns = Solve(*world, {.X_WT = poses, .X_WB = X_WB, .seeds = seeds});
  EXPECT_THAT(columns.status, Each(PoseStatus::kSolved));
  EXPECT_NEAR(columns.rows.at(0), 0, 1e-6);
  EXPECT_NEAR(columns.rows.at(3), kQuarter, 1e-6);
}

TEST_F(ArmAmongBalls, GivesTheSameBytesOnAnyNumberOfThreads) {
  const auto world = WorldWith(true, false);
  std::vector<Pose> poses;
  for (int k = 0; k < 200; ++k) poses.push_back(WristAt(0.004 * k, 0.5, 0.01 * k));
  const PoseBatch batch{.X_WT = poses, .seeds = seed_, .max_solutions = 2, .avoid_collision = true};
  const PoseColumns one = Solve(*world, batch, 1), three = Solve(*world, batch, 3);
  EXPECT_EQ(one.status, three.status);
  EXPECT_EQ(one.row_begin, three.row_begin);
  EXPECT_EQ(one.rows, three.rows);
  EXPECT_EQ(one.completed, poses.size());
}

}  // namespace
}  // namespace cwm::collision
