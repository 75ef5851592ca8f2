#include "tests/perception/table_scene.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace cwm::perception {

PinholeCamera TableCamera() {
  constexpr double kDown_rad = 35 * std::numbers::pi / 180;
  PinholeCamera camera;
  const Vector3 forward(std::cos(kDown_rad), 0, -std::sin(kDown_rad)), right(0, -1, 0);
  camera.X_WC.linear() << right, forward.cross(right), forward;
  camera.X_WC.translation() = -1.1 * forward;
  return camera;
}

SimulatedObject Table() {
  return {.name = "table",
          .parts = {{MakeTranslation(0, 0, -0.015), Box{{1.2, 1.0, 0.03}}}},
          .X_WO = Pose::Identity(),
          .is_support = true};
}

SimulatedObject MakeObject(const std::string& name, const Shape& shape, const Pose& X_WO) {
  return {.name = name, .parts = {{.shape = shape}}, .X_WO = X_WO};
}

SceneInterpretation Interpreted(const SimulatedScene& scene) {
  InterpretOptions options;
  options.X_WC = TableCamera().X_WC;
  const SimulatedCloud scan = Scan(scene, TableCamera(), {.seed = 3});
  auto interpretation = InterpretScene(scan.cloud, options);
  EXPECT_TRUE(interpretation.ok()) << interpretation.status();
  return interpretation.ok() ? *std::move(interpretation) : SceneInterpretation();
}

}  // namespace cwm::perception
