// A small robot with a joint of every kind that states distinguish, for tests of worlds.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "collision/robot/kinematics.h"
#include "collision/robot/srdf.h"
#include "collision/world/world_snapshot.h"
#include "tests/collision/robot/robot_text.h"

namespace cwm::collision::testing {

inline Change MakeChange(decltype(Change::what) what) {
  return {.what = std::move(what), .expected_object_revision = {}};
}

// Links base, upper, fore, left, right, tip and free; base and upper have a ball each, tip has two
// boxes. Variables: elbow (revolute), slide (prismatic), grip (prismatic; the joint "other" mimics
// it with factor -1) and the seven of "float"; "bolt" is fixed.
inline std::string ArmUrdf(const std::string& name = "arm", const std::string& radius = "0.1") {
  const auto ball = [&](const std::string& link) {
    return "<link name=\"" + link +
           "\"><collision><origin xyz=\"0 0 0.2\"/><geometry><sphere radius=\"" + radius +
           "\"/></geometry></collision></link>\n";
  };
  const std::string box = "<collision><geometry><box size=\"0.1 0.1 0.1\"/></geometry></collision>";
  return "<robot name=\"" + name + "\">\n" + ball("base") + ball("upper") +
         "<link name=\"fore\"/><link name=\"left\"/><link name=\"right\"/><link name=\"free\"/>\n" +
         "<link name=\"tip\">" + box + box + "</link>\n" +
         JointText("elbow", "revolute", "base", "upper", "<limit lower=\"-1\" upper=\"1\"/>") +
         JointText("slide", "prismatic", "upper", "fore", "<limit lower=\"0\" upper=\"0.5\"/>") +
         JointText("bolt", "fixed", "fore", "tip", "") +
         JointText("grip", "prismatic", "fore", "left", "<limit lower=\"0\" upper=\"0.04\"/>") +
         JointText(
             "other", "prismatic", "fore", "right",
             "<limit lower=\"-0.04\" upper=\"0\"/><mimic joint=\"grip\" multiplier=\"-1\"/>") +
         JointText("float", "floating", "base", "free", "") + "</robot>\n";
}

inline std::string ArmSrdf(const std::string& ready = "0.5") {
  return "<robot name=\"arm\"><group name=\"reach\"><joint name=\"elbow\"/><joint "
         "name=\"slide\"/></group><group_state name=\"ready\" group=\"reach\"><joint "
         "name=\"elbow\" value=\"" +
         ready + "\"/></group_state></robot>";
}

inline std::shared_ptr<const RobotGeometry> Arm(const std::string& urdf = ArmUrdf(),
                                                const std::string& srdf = ArmSrdf(),
                                                std::optional<SphereModel> spheres = std::nullopt) {
  auto robot = ReadUrdf(urdf, NoMeshes);
  EXPECT_TRUE(robot.ok()) << robot.status();
  const auto semantic = ReadSrdf(srdf, *robot);
  EXPECT_TRUE(semantic.ok()) << semantic.status();
  const auto model = MakeRobotModel(*std::move(robot), &*semantic);
  EXPECT_TRUE(model.ok()) << model.status();
  return PrepareRobot(*model, std::move(spheres));
}

inline PutRobot PutArm(const std::string& name,
                       std::shared_ptr<const RobotGeometry> robot = Arm()) {
  std::vector<double> state = DefaultVariables(*robot->model);
  return {
      .name = name, .robot = std::move(robot), .X_WB = Pose::Identity(), .state = std::move(state)};
}

inline SetRobotState SetElbow(const std::string& name, double value) {
  return {
      .name = name, .X_WB = std::nullopt, .joints = {.named = {}, .values = {{"elbow", value}}}};
}

}  // namespace cwm::collision::testing
