// Arms of three joints in a plane, of which all solutions are known by hand.
#pragma once

#include <cmath>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "collision/inverse_kinematics/ik_chain.h"
#include "collision/robot/robot_model.h"
#include "collision/robot/urdf.h"
#include "tests/collision/robot/robot_text.h"

namespace cwm::collision::testing {

inline constexpr double kHandLength_m = 0.2;
inline constexpr double kQuarter = std::numbers::pi / 2;

// Two arms of 0.5 m and a hand of 0.2 m that turn about z; a ball at the elbow.
inline std::string PlanarArm(const std::string& limit = "3.1") {
  const std::string turn =
      "<axis xyz=\"0 0 1\"/><limit lower=\"-" + limit + "\" upper=\"" + limit + "\"/>";
  const std::string along = "<origin xyz=\"0.5 0 0\"/>";
  return Robot(Links("ab") + Ball("c") + Links("de") +
               JointText("shoulder", "revolute", "a", "b", turn) +
               JointText("elbow", "revolute", "b", "c", along + turn) +
               JointText("wrist", "revolute", "c", "d", along + turn) +
               JointText("hand", "fixed", "d", "e", "<origin xyz=\"0.2 0 0\"/>"));
}

inline std::shared_ptr<const RobotModel> ModelOf(const std::string& urdf) {
  return *MakeRobotModel(*ReadUrdf(urdf, NoMeshes), nullptr);
}

// A pose in the plane.
inline Pose Planar(double x_m, double y_m, double angle_rad) {
  Pose X = MakeTranslation(x_m, y_m, 0);
  X.rotate(Eigen::AngleAxisd(angle_rad, Vector3::UnitZ()));
  return X;
}

// The hand's end where the wrist is at (x, y) and the hand points along the angle.
inline Pose WristAt(double x_m, double y_m, double angle_rad) {
  return Planar(x_m + kHandLength_m * std::cos(angle_rad),
                y_m + kHandLength_m * std::sin(angle_rad), angle_rad);
}

}  // namespace cwm::collision::testing
