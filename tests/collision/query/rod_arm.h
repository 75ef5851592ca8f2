// An arm whose distances can be worked out by hand, and things around it.
#pragma once

#include <gmock/gmock.h>

#include <string>
#include <vector>

#include "collision/query/attached_objects.h"
#include "collision/query/query.h"
#include "tests/collision/query/random_world.h"
#include "tests/collision/world/test_arm.h"

namespace cwm::collision {

// Links "base" (a box of 0.2 m at the origin), "rod" (turns about the base's z axis; a ball of 0.05
// m at x = 0.5), and "hand" (slides along the rod from x = 1; a ball of 0.05 m). All pairs of links
// are tested.
inline const char* const kRodArm =
    "<robot name=\"arm\"><link name=\"base\"><collision><geometry><box size=\"0.2 0.2 0.2\"/>"
    "</geometry></collision></link>"
    "<link name=\"rod\"><collision><origin xyz=\"0.5 0 0\"/><geometry><sphere radius=\"0.05\"/>"
    "</geometry></collision></link>"
    "<link name=\"hand\"><collision><geometry><sphere radius=\"0.05\"/></geometry></collision>"
    "</link>"
    "<joint name=\"turn\" type=\"revolute\"><parent link=\"base\"/><child link=\"rod\"/>"
    "<axis xyz=\"0 0 1\"/><limit lower=\"-3\" upper=\"3\"/></joint>"
    "<joint name=\"grip\" type=\"prismatic\"><origin xyz=\"1 0 0\"/><parent link=\"rod\"/>"
    "<child link=\"hand\"/><axis xyz=\"1 0 0\"/><limit lower=\"-1\" upper=\"1\"/></joint></robot>";

inline Change PutRodArm(const std::string& name = "arm", const Pose& X_WB = Pose::Identity()) {
  PutRobot put = testing::PutArm(name, testing::Arm(kRodArm, "<robot name=\"arm\"/>"));
  put.X_WB = X_WB;
  return testing::MakeChange(put);
}

inline Change BallAt(const std::string& name, const Vector3& at, double radius_m = 0.05) {
  return PutOf(name, {{.X_FS = Pose::Identity(), .shape = Sphere{radius_m}}},
               Pose(Eigen::Translation3d(at)));
}
inline Change BoxAt(const std::string& name, const Vector3& size_m, const Pose& X_WO) {
  return PutOf(name, {{.X_FS = Pose::Identity(), .shape = Box{size_m}}}, X_WO);
}

// A box of 0.1 m, attached 0.2 m beyond the hand of "arm".
inline std::vector<Change> HeldBox() {
  return {BoxAt("box", {0.1, 0.1, 0.1}, MakeTranslation(0, 0, 5)),
          testing::MakeChange(AttachObject{
              .name = "box", .robot = "arm", .link = "hand", .X_LO = MakeTranslation(0.2, 0, 0)})};
}

// The robot "arm" of a world with what it carries, in one state or several.
struct RodArmStates {
  explicit RodArmStates(const WorldSnapshot& world)
      : robot(world.FindRobot("arm")),
        body(WithAttachedObjects(BodyFromRobot(*robot, RobotScope::kBoth), world, *robot,
                                 RobotScope::kBoth)) {}

  JointRows Rows() const {
    return {robot->model(),
            robot->model().all,
            {.X_WB = robot->X_WB, .base = robot->state, .rows = rows}};
  }

  WorldRobotPtr robot;
  QueryBody body;
  std::vector<double> rows = {0, 0};  // turn, grip
};

inline auto AreNear(const std::vector<double>& values, double tolerance = 1e-9) {
  return ::testing::Pointwise(::testing::DoubleNear(tolerance), values);
}

}  // namespace cwm::collision
