// How well the width of a can is known that is far away and slim: its lid and the rays beside it tell
// more than its wall.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <variant>

#include "perception/interpret_scene.h"
#include "perception/simulation/virtual_scanner.h"

namespace cwm::perception {
namespace {

constexpr double kRadius_m = 0.024, kLength_m = 0.125;
constexpr double kPixel_m = 0.0022;  // wide, at the can

SimulatedScene CanOnTable() {
  SimulatedScene scene;
  scene.objects.push_back({.name = "table",
                           .parts = {{.shape = Box{{1.2, 1.2, 0.04}}}},
                           .X_WO = MakeTranslation(0, 0, -0.02)});
  scene.objects.push_back({.name = "can",
                           .parts = {{.shape = Cylinder{kRadius_m, kLength_m}}},
                           .X_WO = MakeTranslation(0.05, 0.02, 0.5 * kLength_m)});
  return scene;
}

PinholeCamera FarAway() {
  PinholeCamera camera;
  const Vector3 eye(0, -0.95, 0.7);
  const Vector3 forward = (Vector3(0, 0, 0.03) - eye).normalized();
  const Vector3 right = Vector3::UnitX();
  camera.X_WC.linear() << right, forward.cross(right), forward;
  camera.X_WC.translation() = eye;
  return camera;
}

std::optional<double> FoundRadius_m(std::uint64_t seed) {
  const PinholeCamera camera = FarAway();
  InterpretOptions options;
  options.X_WC = camera.X_WC;
  const auto found = InterpretScene(Scan(CanOnTable(), camera, {.seed = seed}).cloud, options);
  if (!found.ok()) return std::nullopt;
  for (const DetectedObject& object : found->objects) {
    for (const ShapePart& part : object.model->shapes) {
      if (const auto* can = std::get_if<Cylinder>(&part.shape)) return can->radius_m;
    }
  }
  return std::nullopt;
}

TEST(CanSizes, AreToldByTheLidAndByTheRaysBesideTheCan) {
  double squares = 0, worst_m = 0;
  constexpr int kScans = 8;
  for (std::uint64_t seed = 1; seed <= kScans; ++seed) {
    const std::optional<double> radius_m = FoundRadius_m(seed);
    ASSERT_TRUE(radius_m) << "seed " << seed;
    const double error_m = *radius_m - kRadius_m;
    squares += error_m * error_m;
    worst_m = std::max(worst_m, std::abs(error_m));
  }
  EXPECT_LT(std::sqrt(squares / kScans), 0.5 * kPixel_m);
  EXPECT_LT(worst_m, kPixel_m);
}

}  // namespace
}  // namespace cwm::perception
