#include "perception/vessels/revolved_wall.h"

#include <gtest/gtest.h>

#include "tests/perception/model/vessels.h"

namespace cwm::perception {
namespace {

constexpr double kNear_m = 0.001;  // points have no noise; rings are medians of steps of 6 mm

OrientedPoints SeenFromAbove() {
  OrientedPoints points;
  points.viewpoint = Vector3(-0.6, 0, 0.6);
  return points;
}

TEST(FitRevolvedWalls, FindsTheAxisAndTheOutsideOfAnOpenMug) {
  OrientedPoints mug = SeenFromAbove();
  AddMug({0.02, -0.01}, mug);
  const std::vector<RevolvedWall> walls = FitRevolvedWalls(mug, kSerialWork);
  ASSERT_EQ(walls.size(), 1u);
  EXPECT_NEAR((walls[0].AxisAt(0.05) - Vector2(0.02, -0.01)).norm(), 0, kNear_m);
  for (const double z_m : {0.01, 0.05, 0.09}) {
    EXPECT_NEAR(walls[0].OuterRadius_m(z_m), kMugRadius_m, kNear_m) << z_m;
  }
  EXPECT_NEAR(walls[0].Protrusion_m({0.02, 0.05, 0.05}), 0.06 - kMugRadius_m, kNear_m);
  EXPECT_LT(walls[0].Protrusion_m({0.02, -0.01, 0.05}), 0);
}

TEST(FitRevolvedWalls, IsNotMovedByWhatStandsOut) {
  OrientedPoints mug = SeenFromAbove();
  AddMug(Vector2::Zero(), mug);
  AddTube(Ear(), 0.015, mug);
  const std::vector<RevolvedWall> walls = FitRevolvedWalls(mug, kSerialWork);
  ASSERT_EQ(walls.size(), 1u);
  EXPECT_NEAR(walls[0].AxisAt(0.05).norm(), 0, kNear_m);
  EXPECT_NEAR(walls[0].OuterRadius_m(0.05), kMugRadius_m, kNear_m);
}

TEST(FitRevolvedWalls, FindsBothOfTwoMugsInOneObject) {
  OrientedPoints mugs = SeenFromAbove();
  AddMug({0, -0.05}, mugs);
  AddMug({0, 0.05}, mugs);
  const std::vector<RevolvedWall> walls = FitRevolvedWalls(mugs, kSerialWork);
  ASSERT_EQ(walls.size(), 2u);
  EXPECT_NEAR((walls[0].AxisAt(0.05) - walls[1].AxisAt(0.05)).norm(), 0.1, 2 * kNear_m);
}

TEST(FitRevolvedWalls, FindsNoneInABox) {
  OrientedPoints box = SeenFromAbove();
  for (double along = -0.05; along < 0.05; along += 0.002) {
    for (double z = 0; z < 0.1; z += 0.002) {
      for (const bool first : {true, false}) {
        const Vector3 p = first ? Vector3(-0.05, along, z) : Vector3(along, -0.05, z);
        box.points.push_back(p.cast<float>());
        box.normals.push_back(first ? -Eigen::Vector3f::UnitX() : -Eigen::Vector3f::UnitY());
        box.sigma_m.push_back(0.0015f);
      }
    }
  }
  EXPECT_TRUE(FitRevolvedWalls(box, kSerialWork).empty());
  EXPECT_TRUE(FitRevolvedWalls({}, kSerialWork).empty());
}

}  // namespace
}  // namespace cwm::perception
