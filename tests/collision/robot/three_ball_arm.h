// The robot of ThreeBalls() (robot_text.h) as a model.
#pragma once

#include <gtest/gtest.h>

#include <memory>

#include "collision/robot/robot_model.h"
#include "tests/collision/robot/robot_text.h"

namespace cwm::collision::testing {

inline std::shared_ptr<const RobotModel> ThreeBallArm() {
  const auto description = ReadUrdf(Robot(ThreeBalls()), NoMeshes);
  EXPECT_TRUE(description.ok()) << description.status();
  return *MakeRobotModel(*description, nullptr);
}

}  // namespace cwm::collision::testing
