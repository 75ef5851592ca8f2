// Spheres that contain a robot prove its states free, and never that they collide.
#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "collision/motion/check_paths.h"
#include "collision/query/robot_body.h"
#include "tests/collision/query/rod_arm.h"

namespace cwm::collision {
namespace {

// Three links that fold onto each other: long boxes side by side, whose spheres overlap in every
// state, 2 cm apart.
const char* const kFoldingArm =
    "<robot name=\"arm\">"
    "<link name=\"a\"><collision><geometry><box size=\"0.5 0.05 0.05\"/></geometry></collision>"
    "</link>"
    "<link name=\"b\"><collision><geometry><box size=\"0.1 0.02 0.02\"/></geometry></collision>"
    "</link>"
    "<link name=\"c\"><collision><geometry><box size=\"0.5 0.05 0.05\"/></geometry></collision>"
    "</link>"
    "<joint name=\"lift\" type=\"prismatic\"><origin xyz=\"0 0 0.07\"/><parent link=\"a\"/>"
    "<child link=\"b\"/><axis xyz=\"0 0 1\"/><limit lower=\"-0.04\" upper=\"0.02\"/></joint>"
    "<joint name=\"turn\" type=\"revolute\"><parent link=\"b\"/><child link=\"c\"/>"
    "<axis xyz=\"0 0 1\"/><limit lower=\"-3\" upper=\"3\"/></joint></robot>";

struct Robots {
  Robots() {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> lift(-0.04, 0.02), turn(-3, 3);
    for (int k = 0; k < 2000; ++k) rows.insert(rows.end(), {lift(random), turn(random)});
  }
  const WorldRobotPtr& robot() const { return robot_; }
  JointRows Rows() const {
    return {robot_->model(), robot_->model().all, {.base = robot_->state, .rows = rows}};
  }

  std::shared_ptr<const WorldSnapshot> world =
      WorldOf({testing::MakeChange(testing::PutArm(
                   "arm", testing::Arm(kFoldingArm,
                                       "<robot name=\"arm\"><disable_collisions link1=\"a\" "
                                       "link2=\"b\" reason=\"\"/><disable_collisions link1=\"b\" "
                                       "link2=\"c\" reason=\"\"/></robot>"))),
               BallAt("ball", {0.25, 0.1, 0.1})});
  std::vector<double> rows;

 private:
  WorldRobotPtr robot_ = world->FindRobot("arm");
};

QueryBody BoundsOf(const WorldRobot& robot, RobotScope scope) {
  QueryBody body = BodyFromBounds(*robot.robot, *robot.robot->prepared_bounds, scope);
  body.self = robot.name;
  return body;
}

TEST(BodyFromBounds, ProvesSelfPairsByTheLinksWhereSpheresTouch) {
  const Robots robots;
  const WorldRobot& robot = *robots.robot();
  ASSERT_TRUE(robot.robot->prepared_bounds.has_value());
  EXPECT_EQ(robot.robot->prepared_bounds->tight_pairs.size(), 1u);
  const auto exact =
      *CheckCollisions(*robots.world, BodyFromRobot(robot, RobotScope::kSelf), robots.Rows(), {});
  const auto bounds =
      *CheckCollisions(*robots.world, BoundsOf(robot, RobotScope::kSelf), robots.Rows(), {});
  EXPECT_EQ(bounds.verdict, exact.verdict);
}

TEST(BodyFromBounds, IsUndecidedWhereOnlySpheresTouch) {
  const Robots robots;
  const WorldRobot& robot = *robots.robot();
  const auto exact =
      *CheckCollisions(*robots.world, BodyFromRobot(robot, RobotScope::kWorld), robots.Rows(), {});
  const auto bounds =
      *CheckCollisions(*robots.world, BoundsOf(robot, RobotScope::kWorld), robots.Rows(), {});
  int free = 0, undecided = 0;
  for (std::size_t k = 0; k < exact.verdict.size(); ++k) {
    EXPECT_NE(bounds.verdict[k], Verdict::kCollision) << k;
    if (bounds.verdict[k] == Verdict::kFree) {
      ++free;
      EXPECT_EQ(exact.verdict[k], Verdict::kFree) << k;
      EXPECT_EQ(bounds.accuracy[k], Accuracy::kExact) << k;
    } else {
      ++undecided;
      EXPECT_EQ(bounds.accuracy[k], Accuracy::kDegraded) << k;
    }
  }
  EXPECT_GT(free, 500);
  EXPECT_GT(undecided, 100);
}

TEST(BodyFromBounds, LeavesMotionsUndecidedWhereSpheresTouch) {
  const Robots robots;
  const WorldRobot& robot = *robots.robot();
  const QueryBody exact = BodyFromRobot(robot, RobotScope::kWorld),
                  bounds = BoundsOf(robot, RobotScope::kWorld);
  std::vector<Path> paths;
  for (std::size_t row = 0; row < 400; row += 2) paths.push_back({.first_row = row});
  const JointRows rows = robots.Rows();
  const auto of_links =
      *CheckPaths(*robots.world, exact, JointWaypoints(robot.model(), exact, rows), paths, {});
  const auto of_spheres =
      *CheckPaths(*robots.world, bounds, JointWaypoints(robot.model(), bounds, rows), paths, {});
  int free = 0;
  for (std::size_t k = 0; k < paths.size(); ++k) {
    EXPECT_NE(of_spheres.verdict[k], MotionVerdict::kContact) << k;
    if (of_spheres.verdict[k] != MotionVerdict::kFree) continue;
    ++free;
    EXPECT_EQ(of_links.verdict[k], MotionVerdict::kFree) << k;
  }
  EXPECT_GT(free, 20);
}

}  // namespace
}  // namespace cwm::collision
