// How accurate the radius of a slim, distant can is: its lid and the rays that pass beside it
// constrain the radius more than its wall does.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <optional>
#include <variant>

#include "perception/interpret_scene.h"
#include "perception/simulation/several_views.h"
#include "perception/simulation/virtual_scanner.h"

namespace cwm::perception {
namespace {

constexpr double kRadius_m = 0.024, kLength_m = 0.125;
constexpr double kPixel_m = 0.0022;  // width of a pixel at the can

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

// The cylinder found in the scene; empty if there is none.
std::optional<ShapePart> FoundIn(const PointCloud& cloud) {
  InterpretOptions options;
  options.X_WC = FarAway().X_WC;
  const auto found = InterpretScene(cloud, options);
  if (!found.ok()) return std::nullopt;
  for (const DetectedObject& object : found->objects) {
    for (const ShapePart& part : object.model->shapes) {
      if (std::holds_alternative<Cylinder>(part.shape)) return part;
    }
  }
  return std::nullopt;
}

std::optional<double> FoundRadius_m(std::uint64_t seed) {
  const std::optional<ShapePart> can = FoundIn(Scan(CanOnTable(), FarAway(), {.seed = seed}).cloud);
  if (!can) return std::nullopt;
  return std::get<Cylinder>(can->shape).radius_m;
}

// The standard deviation of the radius, which is the last parameter of a cylinder; 0 if unknown.
double RadiusSigma_m(const std::optional<ShapePart>& can) {
  if (!can || !can->fit || can->fit->parameter_sigma.size() != 7) return 0;
  return can->fit->parameter_sigma.back();
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

double MedianOfFive(const std::function<double(std::uint64_t seed)>& of) {
  std::array<double, 5> values{};
  for (std::size_t k = 0; k < values.size(); ++k) values[k] = of(k + 1);
  std::ranges::sort(values);
  return values[2];
}

// Three views give three times as many points, which would help three times as much if the views
// were registered exactly. The median of five scans is compared, because registration differs from
// scan to scan.
TEST(CanSizes, AreKnownNoBetterThanViewsOfItAreRegistered) {
  const SimulatedScene scene = CanOnTable();
  const double of_one_m = MedianOfFive([&](std::uint64_t seed) {
    return RadiusSigma_m(FoundIn(Scan(scene, FarAway(), {.seed = seed}).cloud));
  });
  const double of_three_m = MedianOfFive([&](std::uint64_t seed) {
    return RadiusSigma_m(
        FoundIn(ScanFromSeveralViews(scene, FarAway(), 3, {.seed = seed}).cloud.cloud));
  });
  EXPECT_GT(of_one_m, 0.0003);
  EXPECT_LT(of_one_m, 0.003);
  EXPECT_GT(of_three_m, 0.0006);
  EXPECT_LT(of_three_m, 0.004);
}

}  // namespace
}  // namespace cwm::perception
