// Objects at the edges of their supports, whose shadows hide the rest of the support.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "tests/perception/table_scene.h"

namespace cwm::perception {
namespace {

// A camera that looks at the origin from 1.2 m away.
PinholeCamera CameraFrom(double elevation_rad) {
  PinholeCamera camera;
  const Vector3 forward(std::cos(elevation_rad), 0, -std::sin(elevation_rad)), right(0, -1, 0);
  camera.X_WC.linear() << right, forward.cross(right), forward;
  camera.X_WC.translation() = -1.2 * forward;
  return camera;
}

// The number of objects near the place that stand on a support at z = 0.
std::ptrdiff_t ObjectsAt(const Vector3& place, const SimulatedScene& scene,
                         const PinholeCamera& camera, std::uint64_t seed) {
  const SimulatedCloud scan = Scan(scene, camera, {.seed = seed});
  InterpretOptions options;
  options.X_WC = camera.X_WC;
  const auto found = InterpretScene(scan.cloud, options);
  EXPECT_TRUE(found.ok()) << found.status();
  if (!found.ok()) return -1;
  return std::ranges::count_if(found->objects, [&](const DetectedObject& object) {
    if (object.model->shapes.empty() || object.supported_by < 0) return false;
    const auto& support = found->supports[static_cast<std::size_t>(object.supported_by)];
    const ShapePart& part = object.model->shapes.front();
    return ((object.X_WO * part.X_OS).translation() - place).norm() < 0.05 &&
           std::abs(support.X_WO.translation().z()) < 0.005;
  });
}

// A board on a wall, its top at z = 0 and its middle at the origin, and a can beside its end or on
// it.
constexpr double kHalfBoard_m = 0.4, kCanRadius_m = 0.035, kCanHeight_m = 0.2;

SimulatedScene CanAtTheEndOfABoard(const Vector3& can) {
  return {{{.name = "board",
            .parts = {{MakeTranslation(0, 0, -0.01), Box{{0.24, 2 * kHalfBoard_m, 0.02}}}},
            .is_support = true},
           MakeObject("wall", Box{{0.02, 3, 2.5}}, MakeTranslation(0.13, 0, -0.3)),
           MakeObject("can", Cylinder{kCanRadius_m, kCanHeight_m},
                      MakeTranslation(can.x(), can.y(), can.z()))}};
}

class EndOfABoard : public ::testing::TestWithParam<std::uint64_t> {};

// The can stands at the corner, flush with the end: nothing of the board is seen behind it.
TEST_P(EndOfABoard, CarriesTheCanWhoseShadowCutsItOff) {
  for (const double side : {-1.0, 1.0}) {
    const Vector3 can(-0.07, side * (kHalfBoard_m - kCanRadius_m), 0.5 * kCanHeight_m);
    EXPECT_EQ(ObjectsAt(can, CanAtTheEndOfABoard(can), CameraFrom(20 * kDegree), GetParam()), 1)
        << "side " << side;
  }
}

// The can's foot is at the height of the board's top, but the wall is seen below it.
TEST_P(EndOfABoard, DoesNotCarryWhatHangsBesideIt) {
  for (const double side : {-1.0, 1.0}) {
    const Vector3 can(-0.07, side * (kHalfBoard_m + kCanRadius_m + 0.015), 0.5 * kCanHeight_m);
    EXPECT_EQ(ObjectsAt(can, CanAtTheEndOfABoard(can), CameraFrom(20 * kDegree), GetParam()), 0)
        << "side " << side;
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, EndOfABoard, ::testing::Range<std::uint64_t>(1, 4));

// A packet just behind the counter's edge; the fronts of counter and packet are linked.
TEST(EdgeOfACounter, CarriesWhatStandsAtItsFront) {
  const Vector3 packet(-0.3 + 0.05, 0.1, 0.04);
  const SimulatedScene scene{
      {{.name = "counter",
        .parts = {{MakeTranslation(0, 0, -0.02), Box{{0.6, 1.2, 0.04}}}},
        .is_support = true},
       MakeObject("cabinet", Box{{0.56, 1.2, 0.5}}, MakeTranslation(0.02, 0, -0.29)),
       MakeObject("packet", Box{{0.08, 0.14, 0.08}},
                  MakeTranslation(packet.x(), packet.y(), packet.z()))}};
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    EXPECT_EQ(ObjectsAt(packet, scene, CameraFrom(38 * kDegree), seed), 1) << "seed " << seed;
  }
}

}  // namespace
}  // namespace cwm::perception
