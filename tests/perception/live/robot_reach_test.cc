#include "perception/live/robot_reach.h"

#include <gmock/gmock.h>

#include <random>

#include "tests/perception/live/robot_scene.h"

namespace cwm::perception {
namespace {

// A pedestal, a shoulder and an elbow that turn any way, a rail of 0.1 m, and a tool fixed to it.
struct ReachingArm {
  std::vector<ReachJoint> joints = {
      {.parent = -1},
      {.parent = 0, .X_PL = MakeTranslation(0, 0, 0.5), .moves = true},
      {.parent = 1, .X_PL = MakeTranslation(0.3, 0.1, 0), .moves = true},
      {.parent = 2, .X_PL = MakeTranslation(0.2, 0, 0), .moves = true, .travel_m = 0.1},
      {.parent = 3, .X_PL = MakeTranslation(0.05, 0, 0.02)}};
  SmallRobot robot = {.links = {{Cylinder{.radius_m = 0.1, .length_m = 0.4}},
                                {},
                                {Box{{0.1, 0.2, 0.1}}},
                                {},
                                {Sphere{.radius_m = 0.03}}},
                      .poses = {}};
};

TEST(ReachOf, HoldsTheRobotInEveryState) {
  const ReachingArm arm;
  const auto surface = arm.robot.Surface();
  const ReachSphere reach = ReachOf(*surface, arm.joints);
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> slide(-0.1, 0.1);
  double farthest_m = 0;
  for (int i = 0; i < 3000; ++i) {
    std::vector<Pose> X_BL;
    for (const ReachJoint& joint : arm.joints) {
      Pose X_PL = joint.X_PL;
      if (joint.travel_m > 0) {
        X_PL = X_PL * MakeTranslation(slide(random), 0, 0);
      } else if (joint.moves) {
        X_PL.linear() = RandomPose(random, 0).linear();
      }
      X_BL.push_back(joint.parent < 0 ? X_PL
                                      : Pose(X_BL[static_cast<std::size_t>(joint.parent)] * X_PL));
      const LinkSurface& link = surface->links()[X_BL.size() - 1];
      for (const Eigen::Vector3f& p_L : link.vertices_L()) {
        const Vector3 p = X_BL.back() * p_L.cast<double>();
        EXPECT_LE((p - reach.center).norm(), reach.radius_m + 1e-6);
        farthest_m = std::max(farthest_m, (p - reach.center).norm());
      }
    }
  }
  EXPECT_NEAR(reach.center.z(), 0.5, 1e-12);  // the first joint that moves
  EXPECT_LT(reach.radius_m, 1.25 * farthest_m);
}

TEST(ReachOf, IsTheRobotItselfIfNothingMoves) {
  SmallRobot robot;
  robot.links = {{Sphere{.radius_m = 0.1}}};
  const std::vector<ReachJoint> joints = {{.parent = -1}};
  EXPECT_NEAR(ReachOf(*robot.Surface(), joints).radius_m, 0.1 * std::sqrt(3), 1e-3);
}

TEST(ReachOf, AJointWithoutLimitsReachesEverywhere) {
  SmallRobot robot;
  robot.links = {{}, {Sphere{.radius_m = 0.1}}};
  const std::vector<ReachJoint> joints = {
      {.parent = -1},
      {.parent = 0, .moves = true, .travel_m = std::numeric_limits<double>::infinity()}};
  EXPECT_EQ(ReachOf(*robot.Surface(), joints).radius_m, std::numeric_limits<double>::infinity());
}

}  // namespace
}  // namespace cwm::perception
