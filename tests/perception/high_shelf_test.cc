// A shelf on a wall, hardly below the height of the camera: its board is seen at a grazing angle.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "tests/perception/table_scene.h"

namespace cwm::perception {
namespace {

constexpr double kAway_m = 1.25;  // from the camera to the middle of the board
constexpr double kDepth_m = 0.24;

struct Goods {
  std::string name;
  Shape shape;
  double height_m, y_m;
};

std::vector<Goods> GoodsOnTheShelf() {
  return {{"can", Cylinder{0.035, 0.12}, 0.12, -0.25},
          {"packet", Box{{0.06, 0.14, 0.2}}, 0.2, 0.02},
          {"jar", Cylinder{0.05, 0.14}, 0.14, 0.26}};
}

// The top of the board is at z = 0, its middle at the origin.
SimulatedScene WithShelf() {
  SimulatedScene scene{
      {{.name = "shelf",
        .parts = {{MakeTranslation(0, 0, -0.01), Box{{kDepth_m, 0.8, 0.02}}}},
        .is_support = true},
       MakeObject("wall", Box{{0.02, 3, 2.5}}, MakeTranslation(0.5 * kDepth_m + 0.01, 0, -0.3))}};
  for (const Goods& goods : GoodsOnTheShelf()) {
    scene.objects.push_back(MakeObject(goods.name, goods.shape,
                                       MakeTranslation(0.02, goods.y_m, 0.5 * goods.height_m)));
  }
  return scene;
}

// A camera that looks down past the shelf, which appears at the top of its image.
PinholeCamera CameraSeeingIt(double elevation_rad) {
  PinholeCamera camera;
  const double down_rad = elevation_rad + 0.15;
  const Vector3 forward(std::cos(down_rad), 0, -std::sin(down_rad)), right(0, -1, 0);
  camera.X_WC.linear() << right, forward.cross(right), forward;
  camera.X_WC.translation() =
      kAway_m * Vector3(-std::cos(elevation_rad), 0, std::sin(elevation_rad));
  return camera;
}

class HighShelf : public ::testing::TestWithParam<double> {};

TEST_P(HighShelf, IsASupportOfWhatStandsOnIt) {
  const PinholeCamera camera = CameraSeeingIt(GetParam() * std::numbers::pi / 180);
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const SimulatedCloud scan = Scan(WithShelf(), camera, {.seed = seed});
    InterpretOptions options;
    options.X_WC = camera.X_WC;
    const auto scene = InterpretScene(scan.cloud, options);
    ASSERT_TRUE(scene.ok()) << scene.status();
    for (const Goods& goods : GoodsOnTheShelf()) {
      const Vector3 middle(0.02, goods.y_m, 0.5 * goods.height_m);
      const auto stands_there = [&](const DetectedObject& object) {
        if (object.model->shapes.empty() || object.supported_by < 0) return false;
        const auto& support = scene->supports[static_cast<std::size_t>(object.supported_by)];
        const ShapePart& part = object.model->shapes.front();
        const Vector3 found = (object.X_WO * part.X_OS).translation();
        return part.shape.index() == goods.shape.index() && (found - middle).norm() < 0.03 &&
               std::abs(support.X_WO.translation().z()) < 0.005;
      };
      EXPECT_EQ(std::ranges::count_if(scene->objects, stands_there), 1)
          << goods.name << ", seed " << seed;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Elevations_deg, HighShelf, ::testing::Values(8, 10, 12, 13, 15, 17));

}  // namespace
}  // namespace cwm::perception
