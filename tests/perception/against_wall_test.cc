// Objects that stand against a wall, seen by the virtual scanner: none of them becomes part of the
// wall.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "tests/perception/table_scene.h"

namespace cwm::perception {
namespace {

constexpr double kWall_m = 0.25;  // x of the wall's face

struct Goods {
  std::string name;
  Shape shape;
  double depth_m, height_m, y_m;
};

// From 0.4 m left of the camera's view to 0.4 m right of it.
std::vector<Goods> GoodsOfAKitchen() {
  return {{"can", Cylinder{0.04, 0.15}, 0.08, 0.15, -0.36},
          {"packet", Box{{0.06, 0.14, 0.2}}, 0.06, 0.2, -0.2},
          {"jar", Cylinder{0.055, 0.12}, 0.11, 0.12, -0.03},
          {"carton", Box{{0.025, 0.15, 0.22}}, 0.025, 0.22, 0.14},
          {"ball", Sphere{0.05}, 0.1, 0.1, 0.3}};
}

SimulatedScene Kitchen(double gap_m) {
  SimulatedScene scene{
      {Table(), MakeObject("wall", Box{{0.02, 3, 2}}, MakeTranslation(kWall_m + 0.01, 0, 0.5))}};
  for (const Goods& goods : GoodsOfAKitchen()) {
    scene.objects.push_back(MakeObject(
        goods.name, goods.shape,
        MakeTranslation(kWall_m - gap_m - 0.5 * goods.depth_m, goods.y_m, 0.5 * goods.height_m)));
  }
  return scene;
}

class AgainstWall : public ::testing::TestWithParam<double> {};

TEST_P(AgainstWall, ObjectsAreDetectedSeparately) {
  const SceneInterpretation scene = Interpreted(Kitchen(GetParam()));
  for (const Goods& goods : GoodsOfAKitchen()) {
    const Vector3 middle = {kWall_m - GetParam() - 0.5 * goods.depth_m, goods.y_m,
                            0.5 * goods.height_m};
    const auto is_there = [&](const DetectedObject& object) {
      if (object.model->shapes.empty()) return false;
      const ShapePart& part = object.model->shapes.front();
      const Vector3 found = (object.X_WO * part.X_OS).translation();
      return part.shape.index() == goods.shape.index() && (found - middle).norm() < 0.02;
    };
    EXPECT_EQ(std::ranges::count_if(scene.objects, is_there), 1) << goods.name;
  }
}

INSTANTIATE_TEST_SUITE_P(Gaps_m, AgainstWall, ::testing::Values(0, 0.005, 0.01, 0.02));

}  // namespace
}  // namespace cwm::perception
