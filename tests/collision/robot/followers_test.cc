// The limits of mimic joints.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "collision/robot/kinematics.h"
#include "collision/robot/mimic.h"
#include "tests/collision/robot/robot_text.h"

namespace cwm::collision {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using testing::JointText;
using testing::Links;
using testing::NoMeshes;
using testing::Robot;
using ModelPtr = std::shared_ptr<const RobotModel>;

constexpr double kRounding = 1e-15;

std::string Limit(const std::string& lower, const std::string& upper) {
  return "<limit lower=\"" + lower + "\" upper=\"" + upper + "\"/>";
}

std::string Mimic(const std::string& joint, const std::string& numbers = "") {
  return "<mimic joint=\"" + joint + "\" " + numbers + "/>";
}

// A finger and a joint that mimics it.
ModelPtr Gripper(const std::string& finger, const std::string& follower,
                 const std::string& kind = "revolute") {
  const auto robot = ReadUrdf(Robot(Links("abc") + JointText("finger", kind, "a", "b", finger) +
                                    JointText("other", kind, "a", "c", follower)),
                              NoMeshes);
  EXPECT_TRUE(robot.ok()) << robot.status();
  return *MakeRobotModel(*robot, nullptr);
}

bool IsWithin(const RobotModel& model, double finger) {
  return !OutOfLimits(model, std::vector<double>{finger}).has_value();
}

TEST(Followers, AreWithinTheirOwnLimitsUpToTheTolerance) {
  const ModelPtr gripper =
      Gripper(Limit("0", "0.8"),
              Limit("-1.2", "0.1") + Mimic("finger", "multiplier=\"-2\" offset=\"0.1\""));
  const double most = (1.2 + 0.1) / 2;  // the mimic joint is at -1.2 there
  EXPECT_TRUE(IsWithin(*gripper, 0));
  EXPECT_TRUE(IsWithin(*gripper, most));
  EXPECT_TRUE(IsWithin(*gripper, most + 0.99 * kMimicTolerance / 2));
  EXPECT_FALSE(IsWithin(*gripper, most + 1.01 * kMimicTolerance / 2));
  EXPECT_FALSE(IsWithin(*gripper, 0.8));
  EXPECT_EQ(gripper->variables[0].lower, 0);
  EXPECT_NEAR(gripper->variables[0].upper, most + kMimicTolerance / 2, kRounding);
  EXPECT_THAT(gripper->narrowing, ElementsAre("other"));
  EXPECT_THAT(gripper->contradicting, IsEmpty());
}

TEST(Followers, ThatRoundingAloneTakesBeyondLeaveTheLimitsAsTheyAre) {
  const ModelPtr gripper =
      Gripper(Limit("0", "0.8757"), Limit("0", "0.592") + Mimic("finger", "multiplier=\"0.676\""));
  EXPECT_GT(0.676 * 0.8757, 0.5919);
  EXPECT_EQ(gripper->variables[0].upper, 0.8757);
  EXPECT_THAT(gripper->narrowing, IsEmpty());
}

TEST(Followers, WithoutLimitsMayBeAnywhere) {
  const auto robot = ReadUrdf(
      Robot(Links("abc") + JointText("wheel", "continuous", "a", "b", "") +
            JointText("other", "continuous", "a", "c", Mimic("wheel", "multiplier=\"40\""))),
      NoMeshes);
  const ModelPtr model = *MakeRobotModel(*robot, nullptr);
  EXPECT_TRUE(IsWithin(*model, 1e6));
}

TEST(Followers, LimitTheJointWithoutLimitsThatTheyFollow) {
  const auto robot =
      ReadUrdf(Robot(Links("abc") + JointText("wheel", "continuous", "a", "b", "") +
                     JointText("other", "prismatic", "a", "c",
                               Limit("0", "0.5") + Mimic("wheel", "multiplier=\"0.01\""))),
               NoMeshes);
  const ModelPtr model = *MakeRobotModel(*robot, nullptr);
  EXPECT_TRUE(IsWithin(*model, 50));
  EXPECT_FALSE(IsWithin(*model, 50.2));
  EXPECT_FALSE(IsWithin(*model, -0.2));
}

TEST(Followers, AlongAChainLimitWhatItEndsAt) {
  const auto robot = ReadUrdf(
      Robot(
          Links("abcd") + JointText("j", "revolute", "a", "b", Limit("-1", "1")) +
          JointText("k", "revolute", "b", "c", Limit("-9", "9") + Mimic("j", "multiplier=\"2\"")) +
          JointText("l", "revolute", "c", "d", Limit("-3", "9") + Mimic("k", "multiplier=\"3\""))),
      NoMeshes);
  const ModelPtr model = *MakeRobotModel(*robot, nullptr);
  EXPECT_TRUE(IsWithin(*model, 1));
  EXPECT_TRUE(IsWithin(*model, -0.5));
  EXPECT_FALSE(IsWithin(*model, -0.501));
}

// Limits in files that work with MoveIt, which ignores the limits of mimic joints: a wrong sign, a
// <limit> of effort and speed only, a constant outside the limits.
TEST(Followers, ThatContradictWhatTheyFollowAreNotKept) {
  for (const std::string& follower :
       {Limit("0", "0.8") + Mimic("finger", "multiplier=\"-1\""),
        "<limit effort=\"10\" velocity=\"1\"/>" + Mimic("finger"),
        Limit("0", "0.8") + Mimic("finger", "multiplier=\"0\" offset=\"2\"")}) {
    const ModelPtr gripper = Gripper(Limit("0", "0.8"), follower);
    EXPECT_EQ(gripper->variables[0].upper, 0.8) << follower;
    EXPECT_TRUE(IsWithin(*gripper, 0.7)) << follower;
    EXPECT_THAT(gripper->contradicting, ElementsAre("other")) << follower;
    EXPECT_THAT(gripper->narrowing, IsEmpty()) << follower;
  }
  const ModelPtr still = Gripper(
      Limit("0", "0.8"), Limit("0", "0.8") + Mimic("finger", "multiplier=\"0\" offset=\"0.4\""));
  EXPECT_THAT(still->contradicting, IsEmpty()) << "a constant within its limits";
  EXPECT_TRUE(IsWithin(*still, 0.7));
}

// Grippers with two fingers, like real ones.
TEST(Followers, OfOrdinaryGrippersLeaveTheirRangeWhole) {
  const ModelPtr panda =
      Gripper(Limit("0.0", "0.04"), Limit("0.0", "0.04") + Mimic("finger"), "prismatic");
  EXPECT_EQ(panda->variables[0].upper, 0.04);
  const ModelPtr robotiq =
      Gripper(Limit("0", "0.8"),
              Limit("-0.8757", "0.0") + Mimic("finger", "multiplier=\"-1\" offset=\"0\""));
  EXPECT_EQ(robotiq->variables[0].upper, 0.8);
  for (const ModelPtr& gripper : {panda, robotiq}) {
    EXPECT_THAT(gripper->narrowing, IsEmpty());
    EXPECT_THAT(gripper->contradicting, IsEmpty());
  }
}

}  // namespace
}  // namespace cwm::collision
