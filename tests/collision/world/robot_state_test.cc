#include "collision/world/robot_state.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "collision/robot/mimic.h"
#include "collision/world/apply_fault.h"
#include "tests/collision/world/test_arm.h"

namespace cwm::collision {
namespace {

using testing::Arm;
using testing::ArmUrdf;

class RobotState : public ::testing::Test {
 protected:
  const RobotModel& model() const { return *arm_->model; }
  std::vector<double> With(const JointValues& joints) {
    auto state = StateWith(model(), DefaultVariables(model()), joints);
    EXPECT_TRUE(state.ok()) << state.status();
    return state.ok() ? *state : std::vector<double>{};
  }
  FieldRule Refusal(const JointValues& joints) {
    const auto state = StateWith(model(), DefaultVariables(model()), joints);
    EXPECT_FALSE(state.ok());
    return FieldRuleOf(state.status()).value_or(FieldRule{"none", ""});
  }
  static JointValues Values(std::vector<VariableValue> values) {
    return {.named = {}, .values = std::move(values)};
  }

  std::shared_ptr<const RobotGeometry> arm_ = Arm();
};

TEST_F(RobotState, KeepsWhatIsNotNamed) {
  std::vector<double> expected = DefaultVariables(model());
  EXPECT_EQ(With({}), expected);
  expected[1] = 0.3;
  EXPECT_EQ(With(Values({{"slide", 0.3}})), expected);
}

TEST_F(RobotState, IsFirstTheNamedOneThenSingleVariables) {
  const JointValues::Named ready{"reach", "ready"};
  EXPECT_EQ(With({.named = ready, .values = {}})[0], 0.5);
  const auto both = With({.named = ready, .values = {{"elbow", -0.5}, {"slide", 0.1}}});
  EXPECT_EQ(both[0], -0.5);
  EXPECT_EQ(both[1], 0.1);
}

TEST_F(RobotState, IsNotOneOfTheSrdfThatSaysNothingOfJointsThatMove) {
  const auto stiff = Arm(ArmUrdf(),
                         R"(<robot name="arm"><group name="hand"><joint name="bolt"/></group>
          <group_state name="open" group="hand"><joint name="bolt" value="1"/></group_state></robot>)");
  const auto refused = StateWith(*stiff->model, DefaultVariables(*stiff->model),
                                 {.named = JointValues::Named{"hand", "open"}, .values = {}});
  ASSERT_FALSE(refused.ok());
  const FieldRule rule = *FieldRuleOf(refused.status());
  EXPECT_EQ(rule.field, "named_state");
  EXPECT_THAT(rule.rule, ::testing::StartsWith("is \"open\", of which the SRDF says nothing"));
}

TEST_F(RobotState, MayLieOutsideTheLimits) { EXPECT_EQ(With(Values({{"elbow", 3}}))[0], 3); }

TEST_F(RobotState, TakesReportsOfJointsWithoutVariablesThatAgree) {
  const double near = 0.99 * kMimicTolerance, far = 1.01 * kMimicTolerance;
  With(Values({{"bolt", 0}, {"grip", 0.02}, {"other", -0.02 - near}}));
  With(Values({{"other", -0.02}, {"grip", 0.02}}));
  EXPECT_EQ(Refusal(Values({{"grip", 0.02}, {"other", -0.02 - far}})).field, "values[1].value");
  EXPECT_EQ(Refusal(Values({{"bolt", 0.1}})).field, "values[0].value");
}

TEST_F(RobotState, NamesWhatTheRobotDoesNotHave) {
  EXPECT_EQ(Refusal({.named = JointValues::Named{"arm", "ready"}, .values = {}}).field, "group");
  const FieldRule state = Refusal({.named = JointValues::Named{"reach", "home"}, .values = {}});
  EXPECT_EQ(state.field, "named_state");
  EXPECT_EQ(state.rule, "is \"home\", must be a state of \"reach\"");
  const FieldRule variable = Refusal(Values({{"elbow", 0}, {"knee", 0}}));
  EXPECT_EQ(variable.field, "values[1].variable");
  EXPECT_EQ(variable.rule, "is \"knee\", must be a variable of \"arm\"");
  EXPECT_EQ(Refusal(Values({{"float", 0}})).field, "values[0].variable");
}

TEST_F(RobotState, RefusesValuesThatAreNone) {
  EXPECT_EQ(Refusal(Values({{"elbow", std::nan("")}})).field, "values[0].value");
  EXPECT_EQ(Refusal(Values({{"elbow", -INFINITY}})).field, "values[0].value");
  EXPECT_EQ(Refusal(Values({{"slide", 1.1e6}})).field, "values[0].value");
  EXPECT_EQ(Refusal(Values({{"elbow", 0}, {"elbow", 0}})).field, "values[1].variable");
}

TEST_F(RobotState, NeedsQuaternionsOfLengthOne) {
  const double half = std::sqrt(0.5);
  With(Values({{"float/rot_z", half}, {"float/rot_w", half}}));
  EXPECT_EQ(Refusal(Values({{"float/rot_w", 0.98}})).field, "values");
  EXPECT_EQ(Refusal(Values({{"float/rot_z", half}})).field, "values");
}

}  // namespace
}  // namespace cwm::collision
