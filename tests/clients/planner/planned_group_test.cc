#include "clients/planner/planned_group.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace cwm::planner {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

void AddVariable(v1::Robot& robot, const std::string& name, v1::JointKind kind, double value) {
  v1::RobotVariable& variable = *robot.add_variables();
  variable.set_name(name);
  variable.set_joint(name);
  variable.set_joint_kind(kind);
  if (kind == v1::JOINT_KIND_REVOLUTE) {
    variable.set_lower(-2);
    variable.set_upper(2);
  }
  robot.add_state(value);
}

v1::NamedState& AddState(v1::RobotGroup& group, const std::string& name) {
  v1::NamedState& state = *group.add_states();
  state.set_name(name);
  return state;
}

// A wheel, an arm of two joints, and a slide without limits.
v1::Robot Crane() {
  v1::Robot robot;
  robot.set_name("crane");
  AddVariable(robot, "wheel", v1::JOINT_KIND_CONTINUOUS, 7);
  AddVariable(robot, "lift", v1::JOINT_KIND_REVOLUTE, 0.5);
  AddVariable(robot, "bend", v1::JOINT_KIND_REVOLUTE, -0.5);
  AddVariable(robot, "slide", v1::JOINT_KIND_PRISMATIC, 0);
  v1::RobotGroup& arm = *robot.add_groups();
  arm.set_name("arm");
  arm.add_joints("lift");
  arm.add_joints("bend");
  v1::VariableValue& value = *AddState(arm, "up").add_values();
  value.set_variable("lift");
  value.set_value(1.5);
  v1::RobotGroup& base = *robot.add_groups();
  base.set_name("base");
  base.add_joints("wheel");
  AddState(base, "up");
  return robot;
}

TEST(PlannedGroup, HasItsJointsWithLimitsAsTheRobotStands) {
  const auto arm = ReadPlannedGroup(Crane(), "arm");
  ASSERT_TRUE(arm.ok()) << arm.status();
  ASSERT_EQ(arm->joints.size(), 2u);
  EXPECT_EQ(arm->joints[1].name, "bend");
  EXPECT_EQ(arm->joints[1].lower, -2);
  EXPECT_THAT(arm->current, ElementsAre(0.5, -0.5));
  const auto base = ReadPlannedGroup(Crane(), "base");
  ASSERT_TRUE(base.ok());
  EXPECT_EQ(base->joints[0].kind, Joint::Kind::kContinuous);
}

TEST(PlannedGroup, RefusesGroupsThatAreNotThereAndJointsWithoutLimits) {
  EXPECT_THAT(std::string(ReadPlannedGroup(Crane(), "leg").status().message()),
              HasSubstr("group is \"leg\", must be one of crane: arm, base"));
  EXPECT_THAT(std::string(ReadPlannedGroup(Crane(), "").status().message()),
              HasSubstr("joint slide is without limits"));
}

TEST(PlannedGroup, KnowsTheStatesOfTheSrdfByName) {
  const v1::Robot crane = Crane();
  const PlannedGroup arm = *ReadPlannedGroup(crane, "arm");
  EXPECT_THAT(*NamedState(crane, arm, "up"), ElementsAre(1.5, -0.5));
  EXPECT_THAT(std::string(NamedState(crane, arm, "down").status().message()),
              HasSubstr("a named state: up"));
  EXPECT_THAT(
      std::string(NamedState(crane, *ReadPlannedGroup(crane, "base"), "up").status().message()),
      HasSubstr("\"up\" says nothing that joints of base can take"));
  v1::Robot short_crane = crane;
  short_crane.mutable_variables()->RemoveLast();
  const PlannedGroup all = *ReadPlannedGroup(short_crane, "");
  EXPECT_THAT(std::string(NamedState(short_crane, all, "up").status().message()),
              HasSubstr("is a state of arm and base: say which with --group"));
}

TEST(PlannedGroup, TakesAGoalOfEveryJointAndNoOther) {
  const PlannedGroup arm = *ReadPlannedGroup(Crane(), "arm");
  EXPECT_THAT(*RowOfAllJoints(arm, {{"bend", 1}, {"lift", 2}}), ElementsAre(2, 1));
  EXPECT_THAT(std::string(RowOfAllJoints(arm, {{"bend", 1}}).status().message()),
              HasSubstr("lift is missing"));
  EXPECT_THAT(
      std::string(RowOfAllJoints(arm, {{"bend", 1}, {"lift", 2}, {"wheel", 3}}).status().message()),
      HasSubstr("wheel must be a joint of the group"));
}

}  // namespace
}  // namespace cwm::planner
