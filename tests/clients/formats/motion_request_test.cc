#include "clients/formats/motion_request.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

namespace cwm::formats {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr char kRequest[] = R"(group_name: arm
allowed_planning_time: 2.5
start_state:
  joint_state: {name: [lift, bend], position: [0.1, -0.2]}
goal_constraints:
  - joint_constraints:
      - {position: 1.5, joint_name: lift, tolerance_above: 0.1}
      - {joint_name: bend, position: -1}
    position_constraints: []
)";

TEST(MotionRequest, ReadsGroupTimeStartAndGoal) {
  const auto request = ParseMotionRequest(kRequest, "r.yaml");
  ASSERT_TRUE(request.ok()) << request.status();
  EXPECT_EQ(request->group, "arm");
  EXPECT_EQ(request->allowed_time_s, 2.5);
  ASSERT_EQ(request->start.joints.size(), 2u);
  EXPECT_EQ(request->start.joints[1].name, "bend");
  EXPECT_EQ(request->start.joints[1].position, -0.2);
  ASSERT_EQ(request->goal.size(), 2u);
  EXPECT_EQ(request->goal[0].name, "lift");
  EXPECT_EQ(request->goal[0].position, 1.5);
  EXPECT_TRUE(request->warnings.empty());
}

TEST(MotionRequest, NeedsNothingButAGoal) {
  const auto request = ParseMotionRequest(
      "goal_constraints: [{joint_constraints: [{joint_name: a, position: 0}]}]\n"
      "allowed_planning_time: 0\n",
      "r.yaml");
  ASSERT_TRUE(request.ok()) << request.status();
  EXPECT_EQ(request->group, "");
  EXPECT_FALSE(request->allowed_time_s.has_value()) << "MoveIt's default is told by 0";
  EXPECT_TRUE(request->start.empty());
}

TEST(MotionRequest, RefusesLiesByFieldValueAndRule) {
  struct InvalidFile {
    std::string from, to, field, rule;
  };
  const std::vector<InvalidFile> invalid_files = {
      {"position: 1.5", "position: up", "goal_constraints[0].joint_constraints[0].position is up",
       "number"},
      {"position: 1.5", "position: .nan", "goal_constraints[0].joint_constraints[0].position",
       "finite"},
      {"joint_name: bend", "joint_name: lift",
       "goal_constraints[0].joint_constraints[1].joint_name is lift", "must not appear twice"},
      {"joint_name: bend", "joint: bend", "goal_constraints[0].joint_constraints[1].joint_name",
       "must be a name"},
      {"position_constraints: []", "position_constraints: [{link_name: hand}]",
       "goal_constraints[0].position_constraints", "joints alone are planned to"},
      {"- joint_constraints:", "- {}\n  - joint_constraints:", "goal_constraints",
       "must hold one goal, holds 2"},
      {"goal_constraints:", "goals:", "goal_constraints", "must be a list of one goal"},
      {"position: [0.1, -0.2]", "position: [0.1]", "start_state.joint_state.position",
       "one for each of 2 names"},
      {"name: [lift, bend]", "name: [bend, bend]", "start_state.joint_state.name[1] is bend",
       "must not appear twice"},
      {"allowed_planning_time: 2.5", "allowed_planning_time: -1", "allowed_planning_time is -1",
       "must not be negative"},
      {"group_name: arm", "path_constraints: {orientation_constraints: [{}]}",
       "path_constraints.orientation_constraints", "joints alone"},
      {"group_name: arm", "group_name: [", "YAML", ""},
  };
  for (const InvalidFile& invalid : invalid_files) {
    std::string text = kRequest;
    text.replace(text.find(invalid.from), invalid.from.size(), invalid.to);
    const auto request = ParseMotionRequest(text, "r.yaml");
    ASSERT_FALSE(request.ok()) << invalid.to;
    EXPECT_THAT(std::string(request.status().message()),
                AllOf(HasSubstr("r.yaml: " + invalid.field), HasSubstr(invalid.rule)));
  }
}

TEST(MotionRequest, SurvivesTheCutAtEveryByte) {
  const std::string text = kRequest;
  for (std::size_t size = 0; size < text.size(); ++size) {
    const auto request = ParseMotionRequest(text.substr(0, size), "r.yaml");
    EXPECT_TRUE(!request.ok() || !request->goal.empty()) << size;
  }
}

}  // namespace
}  // namespace cwm::formats
