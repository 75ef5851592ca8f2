#include "collision/robot/named_states.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/collision/robot/robot_text.h"

namespace cwm::collision {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using testing::JointText;
using testing::Links;
using testing::NoMeshes;
using testing::Robot;

// Fingers ab and ac (= 0.01 - 2 ab), a joint ad outside their group, and a fixed joint ae.
std::shared_ptr<const RobotModel> HandWith(const std::string& positions) {
  auto robot = ReadUrdf(
      Robot(Links("abcde") + JointText("ab", "prismatic", "a", "b") +
            JointText("ac", "prismatic", "a", "c",
                      "<limit/><mimic joint=\"ab\" multiplier=\"-2\" offset=\"0.01\"/>") +
            JointText("ad", "revolute", "a", "d") + JointText("ae", "fixed", "a", "e", "")),
      NoMeshes);
  EXPECT_TRUE(robot.ok()) << robot.status();
  const auto semantic = ReadSrdf(Robot("<group name=\"hand\"><joint name=\"ab\"/><joint "
                                       "name=\"ac\"/><joint name=\"ae\"/></group>"
                                       "<group_state name=\"open\" group=\"hand\">" +
                                       positions + "</group_state>"),
                                 *robot);
  EXPECT_TRUE(semantic.ok()) << semantic.status();
  auto model = MakeRobotModel(*std::move(robot), &*semantic);
  EXPECT_TRUE(model.ok()) << model.status();
  return *std::move(model);
}

std::string At(const std::string& joint, const std::string& value) {
  return "<joint name=\"" + joint + "\" value=\"" + value + "\"/>";
}

const NamedState& OpenOf(const RobotModel& model) { return model.FindGroup("hand")->states.at(0); }

TEST(NamedStates, OfAFollowerAloneSetWhatItFollows) {
  const auto hand = HandWith(At("ac", "-0.07"));
  EXPECT_THAT(OpenOf(*hand).variables, ElementsAre(0));
  EXPECT_THAT(OpenOf(*hand).values, ElementsAre(::testing::DoubleNear(0.04, 1e-15)));
  EXPECT_THAT(hand->left_out, IsEmpty());
}

TEST(NamedStates, TakeFollowersThatAgreeAndTellOfThoseThatDoNot) {
  for (const std::string& positions :
       {At("ab", "0.04") + At("ac", "-0.07"), At("ac", "-0.07") + At("ab", "0.04")}) {
    const auto hand = HandWith(positions);
    EXPECT_THAT(OpenOf(*hand).values, ElementsAre(0.04));
    EXPECT_THAT(hand->left_out, IsEmpty());
  }
  const auto hand = HandWith(At("ac", "0.04") + At("ab", "0.04"));
  EXPECT_THAT(OpenOf(*hand).values, ElementsAre(0.04));
  EXPECT_THAT(hand->left_out, ElementsAre("srdf: group_state \"open\": joint \"ac\" is 0.04, but "
                                          "\"ab\" puts it at -0.07; left out"));
}

TEST(NamedStates, TellOfEveryValueThatNothingTakes) {
  const auto hand = HandWith(At("ad", "1") + At("ae", "0.04"));
  EXPECT_THAT(OpenOf(*hand).variables, IsEmpty());
  EXPECT_THAT(hand->left_out,
              ElementsAre("srdf: group_state \"open\": joint \"ae\" name is \"ae\": must not be "
                          "fixed; left out",
                          "srdf: group_state \"open\": joint \"ad\" is not one of group \"hand\"; "
                          "left out"));
}

TEST(NamedStates, TellOfVirtualJointsWhichTheyDoNotPlace) {
  auto robot = ReadUrdf(Robot(Links("ab") + JointText("ab", "revolute", "a", "b")), NoMeshes);
  ASSERT_TRUE(robot.ok()) << robot.status();
  const auto semantic = ReadSrdf(
      Robot("<virtual_joint name=\"base\" type=\"planar\" parent_frame=\"w\" child_link=\"a\"/>"
            "<group name=\"arm\"><joint name=\"base\"/><joint name=\"ab\"/></group>"
            "<group_state name=\"home\" group=\"arm\"><joint name=\"base\" value=\"1 2 0\"/>" +
            At("ab", "0.5") + "</group_state>"),
      *robot);
  ASSERT_TRUE(semantic.ok()) << semantic.status();
  EXPECT_THAT(
      semantic->left_out,
      ElementsAre("srdf: group_state \"home\": joint \"base\" name is \"base\": must not be "
                  "virtual: a question's x_world_base says where the robot stands; left "
                  "out"));
  const auto model = MakeRobotModel(*std::move(robot), &*semantic);
  ASSERT_TRUE(model.ok()) << model.status();
  EXPECT_THAT((*model)->FindGroup("arm")->states.at(0).values, ElementsAre(0.5));
}

}  // namespace
}  // namespace cwm::collision
