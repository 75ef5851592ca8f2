// States outside the range of coordinates, which limits of joints and of mimic joints do not
// exclude.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "collision/query/robot_body.h"
#include "collision/query/sphere_check.h"
#include "collision/robot/mimic.h"
#include "tests/collision/query/plain_rows.h"
#include "tests/collision/query/random_world.h"
#include "tests/collision/robot/robot_text.h"

namespace cwm::collision {
namespace {

using testing::Ball;
using ::testing::ElementsAre;
using testing::JointText;
using testing::NoMeshes;
using testing::Robot;

std::shared_ptr<const RobotGeometry> Load(const std::string& elements) {
  const auto description = ReadUrdf(Robot(elements), NoMeshes);
  EXPECT_TRUE(description.ok()) << description.status();
  const auto model = MakeRobotModel(*description, nullptr);
  EXPECT_TRUE(model.ok()) << model.status();
  return PrepareRobot(*model, std::nullopt);
}

// A rail with limits beyond the range of coordinates, and a carriage that mimics it with
// `multiplier`.
std::shared_ptr<const RobotGeometry> Rail(const std::string& multiplier) {
  return Load(
      Ball("a") + Ball("b") + Ball("c") +
      JointText("rail", "prismatic", "a", "b", "<limit lower=\"-1e9\" upper=\"1e9\"/>") +
      JointText("carriage", "prismatic", "b", "c",
                "<limit lower=\"-1e12\" upper=\"1e12\"/><mimic joint=\"rail\" multiplier=\"" +
                    multiplier + "\"/>"));
}

CollisionColumns Check(const RobotGeometry& robot, const std::vector<double>& rows,
                       const Pose& X_WB = Pose::Identity()) {
  const auto world = WorldOf({PutOf("post", {{.X_FS = Pose::Identity(), .shape = Sphere{0.1}}},
                                    MakeTranslation(0, 1, 0))});
  const JointRows joint_rows(*robot.model, robot.model->all,
                             {.X_WB = X_WB, .base = {0}, .rows = rows});
  const QueryBody body = BodyFromRobot(robot, RobotScope::kBoth);
  const CollisionColumns result = *CheckCollisions(*world, body, joint_rows, {});
  EXPECT_EQ(result.verdict, CheckCollisions(*world, body, PlainRows(joint_rows), {})->verdict);
  return result;
}

TEST(RobotRange, IsAVerdictOfItsOwnToLeave) {
  const auto rail = Rail("1");
  EXPECT_THAT(
      Check(*rail, {4e5, 5e5, 5.1e5, -5.1e5}).verdict,
      ElementsAre(Verdict::kFree, Verdict::kFree, Verdict::kOutOfLimits, Verdict::kOutOfLimits));
  EXPECT_THAT(Check(*rail, {4e5, -4e5}, MakeTranslation(3e5, 0, 0)).verdict,
              ElementsAre(Verdict::kOutOfLimits, Verdict::kFree));
}

TEST(RobotRange, IsLeftByFollowersWhereverTheyEndUp) {
  EXPECT_THAT(Check(*Rail("1e6"), {0.9, 1e3, 1e6}).verdict,
              ElementsAre(Verdict::kFree, Verdict::kOutOfLimits, Verdict::kOutOfLimits));
}

// Enough rows for the SIMD code.
TEST(RobotRange, IsTheSameInLanes) {
  std::mt19937 random(3);
  for (const double base_x_m : {0.0, 9.999e5, 1e6 - 1}) {
    const auto rail = Rail("0.5");
    std::vector<double> rows;
    while (rows.size() < 600) {
      rows.push_back(std::uniform_real_distribution<double>(-150, 150)(random));
      rows.push_back(1e4 * rows.back());
    }
    const CollisionColumns result = Check(*rail, rows, MakeTranslation(base_x_m, 0, 0));
    for (std::size_t k = 0; k < rows.size(); ++k) {
      const double farthest_m =
          std::max(std::abs(base_x_m + rows[k]), std::abs(base_x_m + 1.5 * rows[k]));
      EXPECT_EQ(result.verdict[k] == Verdict::kOutOfLimits, farthest_m > 1e6) << rows[k];
    }
  }
}

// An arm whose hand mimics its elbow, with limits of its own that are narrower than the elbow's.
TEST(FollowersOfARobot, HaveLimitsThatAStateMayLeave) {
  const auto arm = Load(
      Ball("a") + Ball("b") + Ball("c") +
      JointText("elbow", "revolute", "a", "b",
                "<origin xyz=\"0.5 0 0\"/><limit lower=\"-2\" upper=\"2\"/>") +
      JointText("hand", "revolute", "b", "c",
                "<origin xyz=\"0.5 0 0\"/><limit lower=\"-3\" upper=\"1\"/><mimic joint=\"elbow\" "
                "multiplier=\"-2\" offset=\"0.2\"/>"));
  std::vector<double> rows;
  for (double elbow = -2.1; elbow < 2.1; elbow += 0.0101) rows.push_back(elbow);
  ASSERT_GT(rows.size(), 300u) << "lanes take as many";
  const CollisionColumns result = Check(*arm, rows);
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const double hand = -2 * rows[k] + 0.2;
    const bool is_inside =
        std::abs(rows[k]) <= 2 && hand >= -3 - kMimicTolerance && hand <= 1 + kMimicTolerance;
    EXPECT_EQ(result.verdict[k] != Verdict::kOutOfLimits, is_inside) << rows[k];
  }
}

}  // namespace
}  // namespace cwm::collision
