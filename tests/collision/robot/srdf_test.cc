#include "collision/robot/srdf.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/collision/robot/robot_text.h"

namespace cwm::collision {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using testing::JointText;
using testing::Links;
using testing::NoMeshes;
using testing::Robot;

// a -ab- b -bc- c -cd(fixed)- d, and a -ae- e -ef(planar)- f; g is below d and mimics ab.
RobotDescription Tree() {
  return *ReadUrdf(
      Robot(Links("abcdefg") + JointText("ab", "revolute", "a", "b") +
            JointText("bc", "revolute", "b", "c") + JointText("cd", "fixed", "c", "d") +
            JointText("ae", "prismatic", "a", "e") + JointText("ef", "planar", "e", "f") +
            JointText("dg", "revolute", "d", "g", "<limit/><mimic joint=\"ab\"/>")),
      NoMeshes);
}

absl::StatusOr<SemanticDescription> Read(const std::string& elements) {
  return ReadSrdf(Robot(elements), Tree());
}

std::vector<std::string> GroupOf(const std::string& content) {
  const auto semantic = Read("<group name=\"g\">" + content + "</group>");
  EXPECT_TRUE(semantic.ok()) << semantic.status();
  return semantic.ok() ? semantic->groups.at(0).joints : std::vector<std::string>();
}

std::string RefusalOf(const std::string& elements) {
  const auto semantic = Read(elements);
  if (semantic.ok()) return "none";
  EXPECT_EQ(semantic.status().code(), absl::StatusCode::kInvalidArgument);
  return std::string(semantic.status().message());
}

TEST(Srdf, GroupsAreResolvedInTheOrderOfTheRobot) {
  EXPECT_THAT(GroupOf("<joint name=\"bc\"/><joint name=\"ab\"/><joint name=\"bc\"/>"),
              ElementsAre("ab", "bc"));
  EXPECT_THAT(GroupOf("<link name=\"d\"/><link name=\"b\"/>"), ElementsAre("ab", "cd"));
  EXPECT_THAT(GroupOf("<link name=\"a\"/>"), IsEmpty());  // the root has no joint above it
}

TEST(Srdf, ChainsHoldTheJointsBetweenTheirLinks) {
  EXPECT_THAT(GroupOf("<chain base_link=\"b\" tip_link=\"d\"/>"), ElementsAre("bc", "cd"));
  EXPECT_THAT(GroupOf("<chain base_link=\"a\" tip_link=\"g\"/>"),
              ElementsAre("ab", "bc", "cd", "dg"));
  // Chains may go up, and up and down, as in MoveIt.
  EXPECT_THAT(GroupOf("<chain base_link=\"d\" tip_link=\"b\"/>"), ElementsAre("bc", "cd"));
  EXPECT_THAT(GroupOf("<chain base_link=\"f\" tip_link=\"c\"/>"),
              ElementsAre("ab", "bc", "ae", "ef"));
  EXPECT_THAT(GroupOf("<chain base_link=\"b\" tip_link=\"b\"/>"), IsEmpty());
}

TEST(Srdf, GroupsHoldOtherGroupsThatMayComeLater) {
  const auto semantic = Read(R"(<group name="both"><group name="arm"/><group name="base"/></group>
    <group name="arm"><chain base_link="a" tip_link="c"/></group>
    <group name="base"><joint name="ae"/></group>)");
  ASSERT_TRUE(semantic.ok()) << semantic.status();
  ASSERT_EQ(semantic->groups.size(), 3u);
  EXPECT_EQ(semantic->groups[0].name, "both");
  EXPECT_THAT(semantic->groups[0].joints, ElementsAre("ab", "bc", "ae"));
  EXPECT_THAT(semantic->groups[2].joints, ElementsAre("ae"));
}

TEST(Srdf, ReadsStatesEndEffectorsPairsAndTheRest) {
  const auto semantic = Read(R"(
    <virtual_joint name="world_joint" type="floating" parent_frame="world" child_link="a"/>
    <group name="arm"><joint name="world_joint"/><joint name="ab"/><joint name="ef"/></group>
    <group_state name="home" group="arm"><joint name="ab" value=" 0.5 "/>
      <joint name="ef" value="1 2 3"/><joint name="cd" value="7"/></group_state>
    <end_effector name="hand" group="arm" parent_link="d"/>
    <passive_joint name="bc"/><passive_joint name="world_joint"/>
    <disable_collisions link1="a" link2="b" reason="Adjacent"/>
    <disable_collisions link1="c" link2="a"/>
    <disable_default_collisions link="f"/>
    <enable_collisions link1="f" link2="g"/>
    <link_sphere_approximation link="unknown"/>)");
  ASSERT_TRUE(semantic.ok()) << semantic.status();
  ASSERT_EQ(semantic->virtual_joints.size(), 1u);
  EXPECT_EQ(semantic->virtual_joints[0].name, "world_joint");
  EXPECT_EQ(semantic->virtual_joints[0].type, "floating");
  EXPECT_EQ(semantic->virtual_joints[0].parent_frame, "world");
  EXPECT_EQ(semantic->virtual_joints[0].child_link, "a");
  EXPECT_THAT(semantic->groups[0].joints, ElementsAre("ab", "ef"));  // without the virtual joint
  ASSERT_EQ(semantic->states.size(), 1u);
  EXPECT_EQ(semantic->states[0].name, "home");
  EXPECT_EQ(semantic->states[0].group, "arm");
  ASSERT_EQ(semantic->states[0].positions.size(), 2u);  // a fixed joint has none
  EXPECT_EQ(semantic->states[0].positions[0].joint, "ab");
  EXPECT_THAT(semantic->states[0].positions[0].values, ElementsAre(0.5));
  EXPECT_THAT(semantic->states[0].positions[1].values, ElementsAre(1, 2, 3));
  ASSERT_EQ(semantic->end_effectors.size(), 1u);
  EXPECT_EQ(semantic->end_effectors[0].parent_link, "d");
  EXPECT_EQ(semantic->end_effectors[0].parent_group, "");
  EXPECT_THAT(semantic->passive_joints, ElementsAre("bc", "world_joint"));
  ASSERT_EQ(semantic->disabled_pairs.size(), 2u);
  EXPECT_EQ(semantic->disabled_pairs[0].reason, "Adjacent");
  EXPECT_EQ(semantic->disabled_pairs[1].link1, "c");
  EXPECT_EQ(semantic->disabled_pairs[1].link2, "a");
  EXPECT_EQ(semantic->disabled_pairs[1].reason, "");
  EXPECT_THAT(semantic->disabled_links, ElementsAre("f"));
  ASSERT_EQ(semantic->enabled_pairs.size(), 1u);
  EXPECT_EQ(semantic->enabled_pairs[0].link2, "g");
}

TEST(Srdf, WhatNamesWhatThereIsNotIsLeftOutWithALine) {
  const auto semantic = Read(R"(
    <virtual_joint name="v" type="fixed" parent_frame="w" child_link="x"/>
    <group name="g"><joint name="x"/><link name="x"/><chain base_link="a" tip_link="x"/>
      <group name="x"/><joint name="v"/><joint name="ab"/></group>
    <group_state name="s" group="g"><joint name="x" value="1 2 3"/><joint name="ab" value="0.5"/>
      </group_state>
    <group_state name="s" group="x"/>
    <end_effector name="e" group="x" parent_link="a"/>
    <end_effector name="e" group="g" parent_link="x"/>
    <passive_joint name="x"/><passive_joint name="bc"/>
    <disable_collisions link1="a" link2="b"/><disable_collisions link1="a" link2="x"/>
    <enable_collisions link1="x" link2="b"/><disable_default_collisions link="x"/>)");
  ASSERT_TRUE(semantic.ok()) << semantic.status();
  EXPECT_THAT(semantic->virtual_joints, IsEmpty());
  ASSERT_EQ(semantic->groups.size(), 1u);
  EXPECT_THAT(semantic->groups[0].joints, ElementsAre("ab"));
  ASSERT_EQ(semantic->states.size(), 1u);
  ASSERT_EQ(semantic->states[0].positions.size(), 1u);
  EXPECT_EQ(semantic->states[0].positions[0].joint, "ab");
  EXPECT_THAT(semantic->end_effectors, IsEmpty());
  EXPECT_THAT(semantic->passive_joints, ElementsAre("bc"));
  EXPECT_EQ(semantic->disabled_pairs.size(), 1u);
  EXPECT_THAT(semantic->enabled_pairs, IsEmpty());
  EXPECT_THAT(semantic->disabled_links, IsEmpty());
  const std::string link = " is \"x\": must be a link of the robot; left out";
  const std::string joint = " is \"x\": must be a joint of the robot; left out";
  const std::string group = " is \"x\": must be a group of the SRDF; left out";
  EXPECT_THAT(
      semantic->left_out,
      ElementsAre(
          "srdf: virtual_joint \"v\" child_link" + link,
          "srdf: group \"g\": joint \"x\" name" + joint,
          "srdf: group \"g\": link \"x\" name" + link, "srdf: group \"g\": chain tip_link" + link,
          "srdf: group \"g\": group \"x\" name" + group,
          HasSubstr("group \"g\": joint \"v\" name is \"v\": must be a joint"),
          HasSubstr("group_state \"s\": joint \"x\" name" + joint), HasSubstr(" group" + group),
          HasSubstr(" group" + group), HasSubstr(" parent_link" + link), HasSubstr(" name" + joint),
          "srdf: disable_collisions[1] link2" + link, HasSubstr("enable_collisions link1" + link),
          HasSubstr("disable_default_collisions link" + link)));
}

TEST(Srdf, OfAnotherRobotOrOfNothingIsToldByALine) {
  const auto nothing = Read("");
  ASSERT_TRUE(nothing.ok()) << nothing.status();
  EXPECT_THAT(nothing->left_out, ElementsAre(HasSubstr("neither groups nor pairs")));
  const auto other =
      ReadSrdf("<robot name=\"s\"><group name=\"g\"><link name=\"a\"/></group></robot>", Tree());
  ASSERT_TRUE(other.ok()) << other.status();
  EXPECT_THAT(other->left_out, ElementsAre("srdf: is of the robot \"s\", the URDF is of \"r\""));
}

TEST(Srdf, LinesOfWhatIsLeftOutAreBounded) {
  std::string pairs;
  for (std::size_t i = 0; i < kMaxLeftOut + 5; ++i) {
    pairs += "<disable_collisions link1=\"a\" link2=\"x\"/>";
  }
  const auto semantic = Read(pairs);
  ASSERT_TRUE(semantic.ok()) << semantic.status();
  ASSERT_EQ(semantic->left_out.size(), kMaxLeftOut + 1);
  EXPECT_EQ(semantic->left_out.back(), "srdf: 5 more elements that are left out");
}

TEST(Srdf, MalformedElementsAreRefused) {
  EXPECT_EQ(RefusalOf("<group name=\"g\"><chain tip_link=\"a\"/></group>"),
            "srdf: group \"g\": chain base_link: must be given");
  EXPECT_THAT(RefusalOf("<disable_collisions link1=\"a\" link2=\"a\"/>"),
              HasSubstr("must be another link than link1"));
  EXPECT_THAT(RefusalOf("<virtual_joint name=\"v\" type=\"ball\" parent_frame=\"w\" "
                        "child_link=\"a\"/>"),
              HasSubstr("type is \"ball\": must be fixed, planar or floating"));
}

TEST(Srdf, GroupsThatHoldThemselvesAreRefused) {
  EXPECT_EQ(
      RefusalOf("<group name=\"g\"><group name=\"g\"/></group>"),
      "srdf: group \"g\": group \"g\" name is \"g\": must not be a group that holds this one");
  EXPECT_THAT(RefusalOf("<group name=\"g\"><group name=\"h\"/></group>"
                        "<group name=\"h\"><group name=\"i\"/></group>"
                        "<group name=\"i\"><group name=\"g\"/></group>"),
              HasSubstr("must not be a group that holds this one"));
}

TEST(Srdf, NamesMustNotAppearTwice) {
  EXPECT_EQ(RefusalOf("<group name=\"g\"/><group name=\"g\"/>"),
            "srdf: group \"g\": must not appear twice");
  EXPECT_THAT(RefusalOf("<group name=\"g\"/><group_state name=\"s\" group=\"g\"/>"
                        "<group_state name=\"s\" group=\"g\"/>"),
              HasSubstr("group_state \"s\": must not appear twice for a group"));
  EXPECT_EQ(RefusalOf("<group name=\"g\"/><group name=\"h\"/><group_state name=\"s\" group=\"g\"/>"
                      "<group_state name=\"s\" group=\"h\"/>"),
            "none");
  EXPECT_THAT(RefusalOf("<group name=\"g\"/><group_state name=\"s\" group=\"g\"><joint name=\"ab\" "
                        "value=\"0\"/><joint name=\"ab\" value=\"1\"/></group_state>"),
              HasSubstr("must not appear twice in a state with different values"));
  const auto repeated = ReadSrdf(
      "<robot name=\"r\"><group name=\"g\"/><group_state name=\"s\" group=\"g\"><joint "
      "name=\"ab\" value=\"1\"/><joint name=\"ab\" value=\"1.0\"/></group_state></robot>",
      Tree());
  ASSERT_TRUE(repeated.ok()) << repeated.status();
  ASSERT_EQ(repeated->states.size(), 1u);
  EXPECT_EQ(repeated->states[0].positions.size(), 1u);
  EXPECT_THAT(repeated->left_out, ::testing::Contains(HasSubstr("appears twice in the state")));
  EXPECT_THAT(RefusalOf("<virtual_joint name=\"ab\" type=\"fixed\" parent_frame=\"w\" "
                        "child_link=\"a\"/>"),
              HasSubstr("must not have the name of another joint"));
}

TEST(Srdf, StatesMustHaveAsManyNumbersAsTheJointVariables) {
  const auto state = [](const std::string& joint, const std::string& value) {
    return RefusalOf("<group name=\"g\"/><group_state name=\"s\" group=\"g\"><joint name=\"" +
                     joint + "\" value=\"" + value + "\"/></group_state>");
  };
  EXPECT_EQ(state("ab", "1 2"),
            "srdf: group_state \"s\": joint \"ab\" value is \"1 2\": must be a finite number");
  EXPECT_THAT(state("ab", "nan"), HasSubstr("must be a finite number"));
  EXPECT_THAT(state("ab", ""), HasSubstr("must be a finite number"));
  EXPECT_THAT(state("ef", "1 2"), HasSubstr("must be 3 finite numbers"));
  EXPECT_EQ(state("cd", "anything"), "none");  // fixed
}

TEST(Srdf, HostileDocumentsAreRefusedAsThoseOfAUrdf) {
  EXPECT_THAT(std::string(ReadSrdf("<robot", Tree()).status().message()),
              HasSubstr("srdf: line 1"));
  EXPECT_THAT(std::string(ReadSrdf("<!DOCTYPE r><robot/>", Tree()).status().message()),
              HasSubstr("srdf: must not have a DOCTYPE"));
  EXPECT_THAT(std::string(ReadSrdf("<urdf/>", Tree()).status().message()),
              HasSubstr("must have <robot>"));
  std::string groups;
  for (int i = 0; i < 3; ++i) groups += "<group name=\"g" + std::to_string(i) + "\"/>";
  EXPECT_EQ(ReadSrdf(Robot(groups), Tree(), {.max_groups = 2}).status().message(),
            "srdf: has 3 groups, must have at most 2");
}

TEST(Srdf, AStopEndsReading) {
  std::stop_source stop;
  stop.request_stop();
  for (const char* text : {"<group name=\"g\"><joint name=\"j\"/></group>",
                           "<disable_collisions link1=\"a\" link2=\"b\"/>"}) {
    EXPECT_TRUE(absl::IsCancelled(ReadSrdf(Robot(text), Tree(), {}, stop.get_token()).status()));
  }
}

}  // namespace
}  // namespace cwm::collision
