// Objects that touch each other, seen by the virtual scanner.
#include "perception/refinement/split/split_standing_solids.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "tests/perception/table_scene.h"

namespace cwm::perception {
namespace {

constexpr double kWithin_m = 0.01;  // mixed pixels take this much from both sides of a border

SimulatedObject Can(double radius_m, double height_m, double y_m) {
  return MakeObject("can", Cylinder{radius_m, height_m}, MakeTranslation(0, y_m, 0.5 * height_m));
}

SimulatedObject Carton(const Vector3& size_m, double y_m, double turned_rad) {
  Pose X_WO = MakeTranslation(0, y_m, 0.5 * size_m.z());
  X_WO.rotate(Eigen::AngleAxisd(turned_rad, Vector3::UnitZ()));
  return MakeObject("carton", Box{size_m}, X_WO);
}

Pose LyingCylinderAt(double x_m, double y_m, double turned_rad, double radius_m) {
  Pose X_WO = MakeTranslation(x_m, y_m, radius_m);
  X_WO.rotate(Eigen::AngleAxisd(turned_rad, Vector3::UnitZ()));
  X_WO.rotate(Eigen::AngleAxisd(0.5 * std::numbers::pi, Vector3::UnitX()));
  return X_WO;
}

// The shapes of objects of one shape each, from -y to y.
std::vector<Placed<Shape>> ShapesOf(const SceneInterpretation& scene) {
  std::vector<Placed<Shape>> shapes;
  for (const DetectedObject& object : scene.objects) {
    EXPECT_EQ(object.model->shapes.size(), 1u);
    if (object.model->shapes.empty()) continue;
    const ShapePart& part = object.model->shapes.front();
    shapes.push_back({object.X_WO * part.X_OS, part.shape});
  }
  std::ranges::sort(shapes, {}, [](const auto& placed) { return placed.X_FS.translation().y(); });
  return shapes;
}

TEST(SplitStandingSolids, CansThatTouchAreTwoObjects) {
  const auto shapes =
      ShapesOf(Interpreted({{Table(), Can(0.033, 0.12, 0), Can(0.04, 0.1, 0.0735)}}));
  ASSERT_EQ(shapes.size(), 2u);
  for (std::size_t k = 0; k < 2; ++k) {
    const auto* cylinder = std::get_if<Cylinder>(&shapes[k].shape);
    ASSERT_NE(cylinder, nullptr) << k;
    EXPECT_NEAR(cylinder->radius_m, k == 0 ? 0.033 : 0.04, 0.003) << k;
  }
}

TEST(SplitStandingSolids, CartonsOfOneHeightAreTwoObjectsWhereTheyAreTurned) {
  const auto shapes = ShapesOf(Interpreted(
      {{Table(), Carton({0.07, 0.07, 0.15}, -0.045, 0.4), Carton({0.07, 0.07, 0.15}, 0.035, 0)}}));
  EXPECT_EQ(shapes.size(), 2u);
}

// The ball juts out so far that nothing is seen between it and its can.
TEST(SplitStandingSolids, WhatRestsOnAPartRestsOnItsObject) {
  const SceneInterpretation scene =
      Interpreted({{Table(), Can(0.033, 0.12, 0), Can(0.04, 0.1, 0.0735),
                    MakeObject("ball", Sphere{0.07}, MakeTranslation(0, 0.0935, 0.17))}});
  ASSERT_EQ(scene.objects.size(), 3u);
  const auto ball =
      std::ranges::find_if(scene.objects, [](const auto& object) { return object.rests_on >= 0; });
  ASSERT_NE(ball, scene.objects.end());
  const DetectedObject& below = scene.objects[static_cast<std::size_t>(ball->rests_on)];
  EXPECT_NEAR(below.X_WO.translation().y(), 0.0735, 0.01);
}

// The fronts of the cartons lie in one plane.
TEST(SplitStandingSolids, CartonsOfThreeHeightsThatAreFlushAreThreeObjects) {
  const auto shapes = ShapesOf(
      Interpreted({{Table(), Carton({0.08, 0.06, 0.15}, -0.061, 0),
                    Carton({0.08, 0.06, 0.12}, 0, 0), Carton({0.08, 0.06, 0.09}, 0.061, 0)}}));
  ASSERT_EQ(shapes.size(), 3u);
  for (std::size_t k = 0; k < 3; ++k) {
    const auto* box = std::get_if<Box>(&shapes[k].shape);
    ASSERT_NE(box, nullptr) << k;
    EXPECT_NEAR(shapes[k].X_FS.translation().z(), 0.075 - 0.015 * static_cast<double>(k), 0.002);
    EXPECT_NEAR(shapes[k].X_FS.translation().y(), 0.061 * (static_cast<double>(k) - 1), kWithin_m);
  }
}

// Turned so that a corner of the upper carton reaches the edge of the lower one, where their fronts
// are one surface.
TEST(SplitStandingSolids, TurnedCartonsOnCartonsAreTwoObjects) {
  constexpr double kDegree_rad = std::numbers::pi / 180;
  for (const double turned_deg : {-10, 0, 15, 20}) {
    SimulatedObject upper = Carton({0.14, 0.12, 0.05}, 0, (turned_deg + 20) * kDegree_rad);
    upper.X_WO.pretranslate(Vector3(0, 0, 0.06));
    const SceneInterpretation scene = Interpreted(
        {{Table(), Carton({0.2, 0.16, 0.06}, 0, turned_deg * kDegree_rad), std::move(upper)}});
    EXPECT_EQ(ShapesOf(scene).size(), 2u) << turned_deg;
    const auto is_on_another = [](const DetectedObject& object) { return object.rests_on >= 0; };
    EXPECT_EQ(std::ranges::count_if(scene.objects, is_on_another), 1) << turned_deg;
  }
}

// The lid stands on the pot only.
TEST(SplitStandingSolids, WhatStandsOnAnotherPartStaysWithIt) {
  SimulatedObject pot = Can(0.035, 0.12, 0);
  pot.parts.push_back({MakeTranslation(0, 0, 0.075), Cylinder{0.015, 0.03}});
  EXPECT_EQ(Interpreted({{Table(), pot}}).objects.size(), 1u);
}

TEST(ContinuesSurface, RodsOnOneAxisDo) {
  const ShapePart rod{LyingCylinderAt(0, 0, 0, 0.04), Cylinder{0.04, 0.08}};
  const auto carries_on = [&](const ShapePart& other) {
    EXPECT_EQ(ContinuesSurface(rod, other, Pose::Identity()),
              ContinuesSurface(other, rod, Pose::Identity()));
    return ContinuesSurface(rod, other, Pose::Identity());
  };
  EXPECT_TRUE(carries_on({LyingCylinderAt(0.003, 0.15, 0.05, 0.042), Cylinder{0.042, 0.06}}));
  EXPECT_FALSE(carries_on({LyingCylinderAt(0.003, 0.15, 0.05, 0.05), Cylinder{0.05, 0.06}}));
  EXPECT_FALSE(carries_on({LyingCylinderAt(0.03, 0.15, 0.05, 0.04), Cylinder{0.04, 0.06}}));
  EXPECT_FALSE(carries_on({LyingCylinderAt(0.003, 0.15, 0.5, 0.04), Cylinder{0.04, 0.06}}));
  EXPECT_FALSE(carries_on({MakeTranslation(0, 0.08, 0.04), Sphere{0.04}}));
}

TEST(ContinuesSurface, BoxesThatAreLevelAndAlignedDo) {
  const auto box = [](const Vector3& size_m, double turned_rad) {
    const SimulatedObject carton = Carton(size_m, 0.08, turned_rad);
    return ShapePart{carton.X_WO, carton.parts.front().shape};
  };
  const ShapePart carton{MakeTranslation(0, 0, 0.1), Box{{0.09, 0.06, 0.2}}};
  const auto carries_on = [&](const ShapePart& other) {
    EXPECT_EQ(ContinuesSurface(carton, other, Pose::Identity()),
              ContinuesSurface(other, carton, Pose::Identity()));
    return ContinuesSurface(carton, other, Pose::Identity());
  };
  EXPECT_TRUE(carries_on(box({0.05, 0.04, 0.202}, 0.15)));
  EXPECT_TRUE(carries_on(box({0.05, 0.04, 0.202}, 0.5 * std::numbers::pi)));
  EXPECT_FALSE(carries_on(box({0.05, 0.04, 0.19}, 0.15)));
  EXPECT_FALSE(carries_on(box({0.05, 0.04, 0.2}, 0.5)));
  EXPECT_FALSE(carries_on({MakeTranslation(0, 0.08, 0.1), Cylinder{0.03, 0.2}}));
}

}  // namespace
}  // namespace cwm::perception
