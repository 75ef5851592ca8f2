#include "clients/grasp/gripper.h"

#include <gmock/gmock.h>

#include <limits>

#include "clients/grasp/plan_grasps.h"

namespace cwm::grasp {
namespace {

using ::testing::HasSubstr;

TEST(Gripper, DefaultsAreValid) { EXPECT_TRUE(Validate(Gripper{}).ok()); }

TEST(Gripper, OpenFingersLeaveTheOpeningBetweenThem) {
  const Gripper gripper;
  const std::vector<GripperBox> boxes = OpenBoxes(gripper);
  ASSERT_EQ(boxes.size(), 3U);
  EXPECT_DOUBLE_EQ(boxes[0].centre_G.x() + boxes[0].size_m.x() / 2, -gripper.opening_m / 2);
  EXPECT_DOUBLE_EQ(boxes[1].centre_G.x() - boxes[1].size_m.x() / 2, gripper.opening_m / 2);
}

TEST(Gripper, PadsAreCentredOnTheGraspAndFingersReachThePalm) {
  const Gripper gripper;
  const std::vector<GripperBox> boxes = OpenBoxes(gripper);
  EXPECT_NEAR(boxes[0].centre_G.z() + boxes[0].size_m.z() / 2, gripper.pad_length_m / 2, 1e-15);
  EXPECT_NEAR(boxes[0].centre_G.z() - boxes[0].size_m.z() / 2,
              boxes[2].centre_G.z() + boxes[2].size_m.z() / 2, 1e-15);
}

TEST(Gripper, ErrorsNameOptionValueAndRule) {
  Gripper gripper;
  gripper.opening_m = -0.01;
  EXPECT_THAT(std::string(Validate(gripper).message()), HasSubstr("--opening: -0.01 m must be"));
  gripper = {};
  gripper.finger_width_m = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(std::string(Validate(gripper).message()), HasSubstr("--finger-width: nan"));
  gripper = {};
  gripper.pad_length_m = 0.06;
  EXPECT_THAT(std::string(Validate(gripper).message()), HasSubstr("at most --finger-length"));
}

TEST(PlanRequest, ErrorsNameOptionValueAndRule) {
  EXPECT_TRUE(Validate(PlanRequest{}).ok());
  EXPECT_THAT(std::string(Validate(PlanRequest{.friction = -1}).message()),
              HasSubstr("--friction: -1 must be 0 to 10"));
  EXPECT_THAT(std::string(Validate(PlanRequest{.clearance_m = 0.05}).message()),
              HasSubstr("--clearance"));
  EXPECT_THAT(std::string(Validate(PlanRequest{.top = 0}).message()), HasSubstr("--top: 0"));
}

}  // namespace
}  // namespace cwm::grasp
