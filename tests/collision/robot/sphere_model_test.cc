#include "collision/robot/sphere_model.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/collision/robot/robot_text.h"

namespace cwm::collision {
namespace {

using testing::Ball;
using testing::JointText;
using testing::Links;
using testing::NoMeshes;
using testing::Robot;

RobotDescription Read(const std::string& elements) {
  const auto robot = ReadUrdf(Robot(elements), NoMeshes);
  EXPECT_TRUE(robot.ok()) << robot.status();
  return *robot;
}

const std::string kJoints =
    JointText("j", "revolute", "a", "b") + JointText("k", "revolute", "b", "c");

TEST(SphereModel, MatchesLinksByName) {
  const auto model = *MakeRobotModel(Read(Links("abc") + kJoints), nullptr);
  const RobotDescription spherized = Read(
      R"(<link name="c"><collision><origin xyz="1 2 3"/><geometry><sphere radius="0.5"/></geometry>
      </collision><collision><geometry><sphere radius="0.25"/></geometry></collision></link>)" +
      Links("ab") + kJoints);
  const auto spheres = SphereModelFromUrdf(spherized, *model);
  ASSERT_TRUE(spheres.ok()) << spheres.status();
  ASSERT_EQ(spheres->links.size(), 3u);
  EXPECT_TRUE(spheres->links[0].empty());
  const std::vector<LinkSphere>& of_c = spheres->links[*model->FindLink("c")];
  ASSERT_EQ(of_c.size(), 2u);
  EXPECT_EQ(of_c[0].center_L, Vector3(1, 2, 3));
  EXPECT_EQ(of_c[0].radius_m, 0.5);
  EXPECT_EQ(of_c[1].center_L, Vector3::Zero());
  EXPECT_EQ(of_c[1].radius_m, 0.25);
}

TEST(SphereModel, RefusesLinksThatTheRobotDoesNotHave) {
  const auto model = *MakeRobotModel(Read(Links("a")), nullptr);
  const auto spheres = SphereModelFromUrdf(Read(Ball("x")), *model);
  EXPECT_EQ(spheres.status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(spheres.status().message(),
            "sphere model: link \"x\": must be a link of the robot \"r\"");
}

TEST(SphereModel, RefusesOtherShapes) {
  const auto model = *MakeRobotModel(Read(Links("a")), nullptr);
  const auto spheres = SphereModelFromUrdf(
      Read("<link name=\"a\"><collision><geometry><box size=\"1 1 1\"/></geometry></collision>"
           "</link>"),
      *model);
  EXPECT_EQ(spheres.status().message(),
            "sphere model: link \"a\": collision[0] is a box: must be a sphere");
}

}  // namespace
}  // namespace cwm::collision
