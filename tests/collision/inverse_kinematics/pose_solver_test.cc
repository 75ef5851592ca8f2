#include "collision/inverse_kinematics/pose_solver.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "collision/robot/kinematics.h"
#include "tests/collision/inverse_kinematics/planar_arm.h"

namespace cwm::collision {
namespace {

using ::testing::DoubleNear;
using ::testing::ElementsAre;
using testing::JointText;
using testing::kQuarter;
using testing::Links;
using testing::ModelOf;
using testing::Planar;
using testing::PlanarArm;
using testing::WristAt;

IkChain ToolChain(const RobotModel& model, const std::string& link) {
  auto chain = MakeIkChain(model, model.all, DefaultVariables(model), *model.FindLink(link),
                           Pose::Identity());
  EXPECT_TRUE(chain.ok()) << chain.status();
  return *std::move(chain);
}

auto Joints(double a, double b, double c) {
  return ElementsAre(DoubleNear(a, 1e-6), DoubleNear(b, 1e-6), DoubleNear(c, 1e-6));
}

TEST(PoseSolver, FindsBothElbowsOfAPlanarArm) {
  const auto model = ModelOf(PlanarArm());
  const IkChain chain = ToolChain(*model, "e");
  const std::vector<double> seed = {0.1, 1.4, 0.1};
  const PoseAnswer answer = PoseSolver(chain).Solve(
      {.X_BT = WristAt(0.5, 0.5, kQuarter), .seed = seed, .max_solutions = 2});
  ASSERT_EQ(answer.solutions.size(), 2u);
  EXPECT_THAT(answer.solutions[0].row, Joints(0, kQuarter, 0)) << "nearest to the seed";
  EXPECT_THAT(answer.solutions[1].row, Joints(kQuarter, -kQuarter, kQuarter));
  EXPECT_LE(answer.solutions[0].position_error_m, 1e-6);
  EXPECT_LE(answer.solutions[0].rotation_error_rad, 1e-6);
}

TEST(PoseSolver, StaysOnTheBranchOfTheSeedIfItMust) {
  const auto model = ModelOf(PlanarArm());
  const IkChain chain = ToolChain(*model, "e");
  PoseSolver solver(chain);
  const Pose X_BT = WristAt(0.5, 0.5, kQuarter);
  const std::vector<double> up = {0.3, 1.2, 0.2}, down = {1.3, -1.2, 1.3};
  const auto solve = [&](const std::vector<double>& seed) {
    return solver.Solve({.X_BT = X_BT, .seed = seed, .same_branch = true}).solutions.at(0).row;
  };
  EXPECT_THAT(solve(up), Joints(0, kQuarter, 0));
  EXPECT_THAT(solve(down), Joints(kQuarter, -kQuarter, kQuarter));
}

TEST(PoseSolver, TellsTheNearestPoseOfOneOutOfReach) {
  const auto model = ModelOf(PlanarArm());
  const IkChain chain = ToolChain(*model, "e");
  const std::vector<double> seed = {0.4, 0.4, 0.4};
  const PoseAnswer answer =
      PoseSolver(chain).Solve({.X_BT = Planar(3, 0, 0), .seed = seed, .max_steps = 300});
  EXPECT_TRUE(answer.solutions.empty());
  EXPECT_EQ(answer.steps, 300);
  // Towards it the stretched arm is singular, so that the search comes near but not to the end.
  EXPECT_NEAR(answer.nearest.position_error_m, 3 - 1.2, 3e-3) << "stretched towards it";
  EXPECT_NEAR(answer.nearest.rotation_error_rad, 0, 0.1);
}

TEST(PoseSolver, KeepsValuesThatDoNotMoveTheTool) {
  const auto model = ModelOf(PlanarArm());
  auto chain = MakeIkChain(*model, model->all, DefaultVariables(*model), *model->FindLink("c"),
                           Pose::Identity());
  ASSERT_TRUE(chain.ok());
  const std::vector<double> seed = {0, 0, 0.77};
  const PoseAnswer answer = PoseSolver(*chain).Solve({.X_BT = Planar(0, 0.5, 2), .seed = seed});
  ASSERT_EQ(answer.solutions.size(), 1u);
  EXPECT_THAT(answer.solutions[0].row, Joints(kQuarter, 2 - kQuarter, 0.77));
}

TEST(PoseSolver, WrapsContinuousJointsToTheSeed) {
  const auto model = ModelOf(testing::Robot(
      Links("ab") + JointText("j", "continuous", "a", "b", "<axis xyz=\"0 1 0\"/>")));
  const IkChain chain = ToolChain(*model, "b");
  Pose X_BT = Pose::Identity();
  X_BT.rotate(Eigen::AngleAxisd(0.5, Vector3::UnitY()));
  const std::vector<double> seed = {20};
  const PoseAnswer answer = PoseSolver(chain).Solve({.X_BT = X_BT, .seed = seed});
  ASSERT_EQ(answer.solutions.size(), 1u);
  EXPECT_NEAR(answer.solutions[0].row[0], 0.5 + 6 * std::numbers::pi, 1e-6);
}

TEST(PoseSolver, MovesJointsThatFollowAnother) {
  // Two slides along x; the second follows the first, twice as far and 0.1 m ahead.
  const std::string slide = "<axis xyz=\"1 0 0\"/><limit lower=\"0\" upper=\"1\"/>";
  const auto model = ModelOf(testing::Robot(
      Links("abc") + JointText("first", "prismatic", "a", "b", slide) +
      JointText("second", "prismatic", "b", "c",
                "<axis xyz=\"1 0 0\"/><limit lower=\"-9\" upper=\"9\"/><mimic joint=\"first\" "
                "multiplier=\"2\" offset=\"0.1\"/>")));
  const IkChain chain = ToolChain(*model, "c");
  const std::vector<double> seed = {0};
  const PoseAnswer answer =
      PoseSolver(chain).Solve({.X_BT = MakeTranslation(1.0, 0, 0), .seed = seed});
  ASSERT_EQ(answer.solutions.size(), 1u);
  EXPECT_NEAR(answer.solutions[0].row[0], 0.3, 1e-6);
}

// A six-jointed arm with a spherical wrist and links of other lengths and axes.
std::string SixJoints() {
  const auto joint = [](const char* name, const char* parent, const char* child, const char* origin,
                        const char* axis) {
    return JointText(name, "revolute", parent, child,
                     std::string("<origin xyz=\"") + origin + "\"/><axis xyz=\"" + axis +
                         "\"/><limit lower=\"-2.8\" upper=\"2.8\"/>");
  };
  return testing::Robot(
      Links("abcdefg") + joint("1", "a", "b", "0 0 0.3", "0 0 1") +
      joint("2", "b", "c", "0.1 0 0.1", "0 1 0") + joint("3", "c", "d", "0 0.02 0.4", "0 1 0") +
      joint("4", "d", "e", "0.05 0 0.2", "0 0 1") + joint("5", "e", "f", "0 0 0.2", "0 1 0") +
      joint("6", "f", "g", "0 0 0.1", "0 0 1"));
}

TEST(PoseSolver, ReachesWhatForwardKinematicsReached) {
  const auto model = ModelOf(SixJoints());
  const IkChain chain = ToolChain(*model, "g");
  PoseSolver solver(chain);
  std::mt19937 random(11);
  std::uniform_real_distribution<double> angle(-2.8, 2.8);
  std::vector<Pose> X_BL(model->links.size());
  const auto draw = [&] {
    std::vector<double> row(6);
    for (double& value : row) value = angle(random);
    return row;
  };
  int solved = 0;
  constexpr int kPoses = 1000;
  for (int k = 0; k < kPoses; ++k) {
    LinkPoses(*model, Pose::Identity(), draw(), X_BL);
    const Pose X_BT = X_BL.back();
    const std::vector<double> seed = draw();
    const PoseAnswer answer = solver.Solve({.X_BT = X_BT, .seed = seed, .max_solutions = 3});
    solved += !answer.solutions.empty();
    for (const PoseSolution& solution : answer.solutions) {
      EXPECT_FALSE(OutOfLimits(*model, solution.row));
      LinkPoses(*model, Pose::Identity(), solution.row, X_BL);
      EXPECT_LT((X_BL.back().translation() - X_BT.translation()).norm(), 1.1e-6);
      const Matrix3 missing = X_BL.back().linear().transpose() * X_BT.linear();
      EXPECT_LT(Eigen::AngleAxisd(missing).angle(), 1.1e-6);
    }
  }
  EXPECT_GE(solved, kPoses - 1);
}

TEST(PoseSolver, GivesTheSameAnswerWhateverItSolvedBefore) {
  const auto model = ModelOf(SixJoints());
  const IkChain chain = ToolChain(*model, "g");
  const std::vector<double> seed(6, 0.1);
  Pose X_BT = MakeTranslation(0.3, 0.2, 0.7);
  const PoseRequest request{.X_BT = X_BT, .seed = seed, .max_solutions = 4};
  PoseSolver fresh(chain), used(chain);
  used.Solve({.X_BT = MakeTranslation(5, 0, 0), .seed = seed});
  const PoseAnswer a = fresh.Solve(request), b = used.Solve(request);
  ASSERT_EQ(a.solutions.size(), b.solutions.size());
  EXPECT_FALSE(a.solutions.empty());
  for (std::size_t k = 0; k < a.solutions.size(); ++k) {
    EXPECT_EQ(a.solutions[k].row, b.solutions[k].row);
  }
}

}  // namespace
}  // namespace cwm::collision
