#include "collision/robot/robot_model.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "tests/collision/robot/robot_text.h"

namespace cwm::collision {
namespace {

using testing::Ball;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using testing::JointText;
using testing::Links;
using testing::NoMeshes;
using testing::Robot;
using ModelPtr = std::shared_ptr<const RobotModel>;

RobotDescription Read(const std::string& elements) {
  const auto robot = ReadUrdf(Robot(elements), NoMeshes);
  EXPECT_TRUE(robot.ok()) << robot.status();
  return *robot;
}

ModelPtr ModelOf(const std::string& elements) { return *MakeRobotModel(Read(elements), nullptr); }

ModelPtr ModelOf(const std::string& elements, const std::string& srdf) {
  const RobotDescription robot = Read(elements);
  const auto semantic = ReadSrdf(Robot(srdf), robot);
  EXPECT_TRUE(semantic.ok()) << semantic.status();
  return *MakeRobotModel(robot, &*semantic);
}

std::vector<std::string> LinksOf(const RobotModel& model) {
  std::vector<std::string> names;
  for (const ModelLink& link : model.links) names.push_back(link.name);
  return names;
}

// The two names of each pair, such as "ab".
std::vector<std::string> PairsOf(const RobotModel& model) {
  std::vector<std::string> pairs;
  for (const LinkPair& pair : model.self_pairs) {
    pairs.push_back(model.links[pair.first].name + model.links[pair.second].name);
  }
  return pairs;
}

TEST(RobotModel, KeepsTheOrderOfAUrdfThatListsParentsFirst) {
  // Neither breadth-first nor depth-first: either walk would change the order.
  const ModelPtr model = ModelOf(
      Links("abcde") + JointText("j1", "fixed", "b", "e") + JointText("j2", "fixed", "a", "c") +
      JointText("j3", "fixed", "a", "b") + JointText("j4", "fixed", "c", "d"));
  EXPECT_THAT(LinksOf(*model), ElementsAre("a", "b", "c", "d", "e"));
}

TEST(RobotModel, PutsParentsFirstAndRemembersThePlaceInTheUrdf) {
  const ModelPtr model =
      ModelOf(Links("dcba") + JointText("j", "fixed", "b", "d") +
              JointText("k", "fixed", "a", "b") + JointText("l", "fixed", "a", "c"));
  EXPECT_THAT(LinksOf(*model), ElementsAre("a", "c", "b", "d"));
  EXPECT_EQ(model->links[0].urdf_index, 3);
  EXPECT_EQ(model->links[1].urdf_index, 1);
  EXPECT_EQ(model->links[3].urdf_index, 0);
  for (std::size_t i = 1; i < model->links.size(); ++i) {
    EXPECT_LT(model->links[i].parent, static_cast<int>(i));
  }
  EXPECT_EQ(model->links[3].joint, "j");
  EXPECT_EQ(model->links[model->links[3].parent].name, "b");
}

TEST(RobotModel, FindsLinksJointsAndGroupsByName) {
  const ModelPtr model = ModelOf(Links("ab") + JointText("j", "revolute", "a", "b"),
                                 "<group name=\"g\"><joint name=\"j\"/></group>");
  EXPECT_EQ(model->FindLink("b"), 1);
  EXPECT_EQ(model->FindLink("x"), std::nullopt);
  EXPECT_EQ(model->FindJoint("j"), 1);
  EXPECT_EQ(model->FindJoint("b"), std::nullopt);
  ASSERT_NE(model->FindGroup("g"), nullptr);
  EXPECT_EQ(model->FindGroup("h"), nullptr);
}

TEST(RobotModel, CountsTheVariablesOfEveryKindAndNamesThemAsMoveItDoes) {
  const ModelPtr model =
      ModelOf(Links("abcdefg") + JointText("r", "revolute", "a", "b") +
              JointText("c", "continuous", "b", "c") + JointText("p", "prismatic", "c", "d") +
              JointText("f", "fixed", "d", "e") + JointText("pl", "planar", "e", "f") +
              JointText("fl", "floating", "f", "g"));
  std::vector<std::string> names;
  for (const Variable& variable : model->variables) names.push_back(variable.name);
  EXPECT_THAT(names,
              ElementsAre("r", "c", "p", "pl/x", "pl/y", "pl/theta", "fl/trans_x", "fl/trans_y",
                          "fl/trans_z", "fl/rot_x", "fl/rot_y", "fl/rot_z", "fl/rot_w"));
  const double inf = std::numeric_limits<double>::infinity();
  EXPECT_EQ(model->variables[0].lower, -1);
  EXPECT_EQ(model->variables[0].upper, 1);
  EXPECT_EQ(model->variables[1].lower, -inf);  // continuous, whatever its <limit> says
  EXPECT_EQ(model->variables[1].upper, inf);
  EXPECT_EQ(model->variables[5].link, 5);
  EXPECT_EQ(model->variables[5].component, 2);
  EXPECT_THAT(model->all.joints, ElementsAre("r", "c", "p", "pl", "fl"));
  EXPECT_EQ(model->all.variables.size(), 13u);
  EXPECT_THAT(model->all.moved_links, ElementsAre(1, 2, 3, 4, 5, 6));
}

TEST(RobotModel, ResolvesFollowersOfFollowersToTheVariableAtTheEnd) {
  const auto mimic = [](const std::string& joint, const std::string& numbers) {
    return "<limit/><mimic joint=\"" + joint + "\" " + numbers + "/>";
  };
  // j = 2 k + 1 and k = 3 l + 0.5, so j = 6 l + 2.
  const ModelPtr model =
      ModelOf(Links("abcd") +
              JointText("j", "revolute", "a", "b", mimic("k", "multiplier=\"2\" offset=\"1\"")) +
              JointText("k", "revolute", "b", "c", mimic("l", "multiplier=\"3\" offset=\"0.5\"")) +
              JointText("l", "revolute", "c", "d"));
  ASSERT_EQ(model->variables.size(), 1u);
  EXPECT_EQ(model->variables[0].name, "l");
  const ModelLink& b = model->links[*model->FindJoint("j")];
  EXPECT_TRUE(b.is_mimic);
  EXPECT_EQ(b.variable, 0);
  EXPECT_EQ(b.multiplier, 6);
  EXPECT_EQ(b.offset, 2);
  EXPECT_FALSE(model->links[*model->FindJoint("l")].is_mimic);
}

TEST(RobotModel, GroupsHoldVariablesInOrderAndTheLinksThatTheyMove) {
  const std::string robot = Links("abcdef") + JointText("ab", "revolute", "a", "b") +
                            JointText("bc", "revolute", "b", "c") +
                            JointText("cd", "fixed", "c", "d") +
                            JointText("ae", "revolute", "a", "e", "<limit/><mimic joint=\"bc\"/>") +
                            JointText("ef", "planar", "e", "f");
  const ModelPtr model = ModelOf(robot, R"(
    <group name="tip"><joint name="cd"/><joint name="bc"/></group>
    <group name="mixed"><joint name="ef"/><joint name="ae"/><joint name="ab"/></group>
    <group name="stiff"><joint name="cd"/></group>)");
  const JointGroup& tip = *model->FindGroup("tip");
  EXPECT_THAT(tip.joints, ElementsAre("bc"));
  EXPECT_THAT(tip.variables, ElementsAre(1));
  // c and d are below bc, the joint of e mimics it, and f is below e.
  EXPECT_THAT(tip.moved_links, ElementsAre(2, 3, 4, 5));
  const JointGroup& mixed = *model->FindGroup("mixed");
  EXPECT_THAT(mixed.joints, ElementsAre("ab", "ef"));
  EXPECT_THAT(mixed.variables, ElementsAre(0, 2, 3, 4));
  EXPECT_THAT(mixed.moved_links, ElementsAre(1, 2, 3, 5));
  EXPECT_THAT(model->FindGroup("stiff")->variables, IsEmpty());
  EXPECT_THAT(model->FindGroup("stiff")->moved_links, IsEmpty());
}

TEST(RobotModel, StatesHoldTheVariablesOfTheirGroupAlone) {
  const ModelPtr model = ModelOf(
      Links("abcd") + JointText("ab", "revolute", "a", "b") + JointText("bc", "planar", "b", "c") +
          JointText("cd", "revolute", "c", "d", "<limit/><mimic joint=\"ab\"/>"),
      R"(<group name="g"><joint name="bc"/><joint name="cd"/></group>
      <group_state name="s" group="g"><joint name="cd" value="0.1"/><joint name="ab" value="0.2"/>
      <joint name="bc" value="1 2 3"/></group_state>)");
  const JointGroup& group = *model->FindGroup("g");
  ASSERT_EQ(group.states.size(), 1u);
  EXPECT_EQ(group.states[0].name, "s");
  EXPECT_THAT(group.states[0].variables, ElementsAre(1, 2, 3));
  EXPECT_THAT(group.states[0].values, ElementsAre(1, 2, 3));
  EXPECT_EQ(model->left_out.size(), 2u);  // "ab", and "cd", which mimics it
}

// A chain of balls a - b - c - d, with revolute joints between them.
const std::string kChain =
    Ball("a") + Ball("b") + Ball("c") + Ball("d") + JointText("ab", "revolute", "a", "b") +
    JointText("bc", "revolute", "b", "c") + JointText("cd", "revolute", "c", "d");

TEST(SelfPairs, WithoutAnSrdfNeighboursAreLeftOut) {
  EXPECT_THAT(PairsOf(*ModelOf(kChain)), ElementsAre("ac", "ad", "bd"));
}

TEST(SelfPairs, WithAnSrdfItAloneSaysWhatIsLeftOut) {
  EXPECT_THAT(PairsOf(*ModelOf(kChain, "")), ElementsAre("ab", "ac", "ad", "bc", "bd", "cd"));
  EXPECT_THAT(PairsOf(*ModelOf(kChain,
                               "<disable_collisions link1=\"c\" link2=\"a\"/>"
                               "<disable_collisions link1=\"a\" link2=\"b\"/>")),
              ElementsAre("ad", "bc", "bd", "cd"));
}

TEST(SelfPairs, DefaultsOfLinksComeBeforePairsThatAreEnabledAndThoseBeforePairsDisabled) {
  EXPECT_THAT(PairsOf(*ModelOf(kChain,
                               "<disable_default_collisions link=\"b\"/>"
                               "<enable_collisions link1=\"b\" link2=\"d\"/>"
                               "<enable_collisions link1=\"b\" link2=\"a\"/>"
                               "<disable_collisions link1=\"a\" link2=\"b\"/>")),
              ElementsAre("ac", "ad", "bd", "cd"));
}

TEST(SelfPairs, LinksWithoutGeometryHaveNoPairsAndPassNeighbourhoodOn) {
  // b has no geometry and lies between two joints: a and c touch there, a and d do not.
  const ModelPtr model = ModelOf(
      Ball("a") + Links("b") + Ball("c") + Ball("d") + JointText("ab", "revolute", "a", "b") +
      JointText("bc", "revolute", "b", "c") + JointText("cd", "revolute", "c", "d"));
  EXPECT_THAT(PairsOf(*model), ElementsAre("ad"));
}

TEST(SelfPairs, FingersOnABareHandAreCheckedAgainstEachOther) {
  const ModelPtr model =
      ModelOf(Links("h") + Ball("l") + Ball("r") + JointText("hl", "prismatic", "h", "l") +
              JointText("hr", "prismatic", "h", "r"));
  EXPECT_THAT(PairsOf(*model), ElementsAre("lr"));
}

TEST(SelfPairs, LinksOfOneBodyNeverMoveAgainstEachOther) {
  // b and c are fixed to a, d turns on c, e is fixed to d.
  const std::string robot =
      Ball("a") + Ball("b") + Ball("c") + Ball("d") + Ball("e") +
      JointText("ab", "fixed", "a", "b") + JointText("bc", "fixed", "b", "c") +
      JointText("cd", "revolute", "c", "d") + JointText("de", "fixed", "d", "e");
  EXPECT_THAT(PairsOf(*ModelOf(robot)), ElementsAre("ad", "ae", "bd", "be", "ce"));
  EXPECT_THAT(PairsOf(*ModelOf(robot, "")), ElementsAre("ad", "ae", "bd", "be", "cd", "ce"));
  const ModelPtr model = ModelOf(robot);
  EXPECT_EQ(model->links[2].body, 0);
  EXPECT_EQ(model->links[3].body, 3);
  EXPECT_EQ(model->links[4].body, 3);
}

TEST(SelfPairs, AreOrderedByTheUrdfWhateverHangsOnWhat) {
  const ModelPtr model =
      ModelOf(Ball("c") + Ball("b") + Ball("a") + JointText("ab", "revolute", "a", "b") +
                  JointText("bc", "revolute", "b", "c"),
              "");
  EXPECT_THAT(LinksOf(*model), ElementsAre("a", "b", "c"));
  EXPECT_THAT(PairsOf(*model), ElementsAre("cb", "ca", "ba"));
}

TEST(RobotModel, RefusesDescriptionsThatNoReaderWouldGive) {
  RobotDescription cyclic = Read(Links("ab") + JointText("j", "fixed", "a", "b"));
  cyclic.joints.push_back(cyclic.joints[0]);
  cyclic.joints.back().name = "k";
  EXPECT_FALSE(MakeRobotModel(cyclic, nullptr).ok());
  const RobotDescription robot = Read(Links("ab") + JointText("j", "fixed", "a", "b"));
  SemanticDescription semantic;
  semantic.groups.push_back({.name = "g", .joints = {"x"}});
  EXPECT_THAT(std::string(MakeRobotModel(robot, &semantic).status().message()),
              HasSubstr("group \"g\": joint is \"x\": must be a joint of the robot"));
}

}  // namespace
}  // namespace cwm::collision
