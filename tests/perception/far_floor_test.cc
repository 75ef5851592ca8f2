// A floor seen past the edge of a table, up to where neighbouring pixels are a metre apart.
#include <gtest/gtest.h>

#include <utility>

#include "tests/perception/table_scene.h"

namespace cwm::perception {
namespace {

TEST(FarFloor, IsASupportToItsEnd) {
  SimulatedObject floor = MakeObject("floor", HalfSpace{}, MakeTranslation(0, 0, -0.75));
  floor.is_support = true;
  const SceneInterpretation scene =
      Interpreted({{Table(), std::move(floor),
                    MakeObject("box", Box{{0.1, 0.1, 0.1}}, MakeTranslation(0, 0, 0.05))}});
  EXPECT_GE(scene.report.points_explained, 0.998 * double(scene.report.points_finite));
  EXPECT_EQ(scene.objects.size(), 1u) << "of the floor's last pixels none is an object";
}

// Beyond five metres noise splits the floor into islands, each of which seems to tilt differently.
TEST(FarFloor, IsOneSupportAcrossIslandsOfNoise) {
  SimulatedObject floor = MakeObject("floor", HalfSpace{}, MakeTranslation(0, 0, -0.75));
  floor.is_support = true;
  const SimulatedScene kitchen{{Table(), std::move(floor)}};
  PinholeCamera camera = TableCamera();
  camera.X_WC.translation() += Vector3(-0.2, 0, 0.15);
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    InterpretOptions options;
    options.X_WC = camera.X_WC;
    const auto scene = InterpretScene(Scan(kitchen, camera, {.seed = seed}).cloud, options);
    ASSERT_TRUE(scene.ok()) << scene.status();
    EXPECT_EQ(scene->supports.size(), 2u) << "table and floor, seed " << seed;
  }
}

}  // namespace
}  // namespace cwm::perception
