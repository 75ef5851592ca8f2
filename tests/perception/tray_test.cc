#include "perception/refinement/merge/tray.h"

#include <gtest/gtest.h>

namespace cwm::perception {
namespace {

const Vector3 kSensor_P(-0.7, -0.4, 0.8);

LoneWall Wall(const Vector2& begin, const Vector2& end, double rim_m = 0.1) {
  LoneWall wall{
      .normal = {end.y() - begin.y(), begin.x() - end.x()}, .ends = {begin, end}, .rim_m = rim_m};
  wall.normal.normalize();
  if (wall.normal.dot(kSensor_P.head<2>() - begin) < 0) wall.normal = -wall.normal;
  return wall;
}

// The walls of a tray of 30 x 20 cm around the origin.
std::vector<LoneWall> FourWalls() {
  return {Wall({-0.15, -0.1}, {-0.15, 0.1}), Wall({0.15, -0.1}, {0.15, 0.1}),
          Wall({-0.15, -0.1}, {0.15, -0.1}), Wall({-0.15, 0.1}, {0.15, 0.1})};
}

TEST(FindTrays, FindsTheRectangleOfFourWalls) {
  const auto boxes = FindTrays(FourWalls(), kSensor_P);
  ASSERT_FALSE(boxes.empty());
  EXPECT_EQ(boxes.front().seen_sides(), 4u);
  EXPECT_NEAR(boxes.front().size_m.minCoeff(), 0.2, 1e-9);
  EXPECT_NEAR(boxes.front().size_m.maxCoeff(), 0.3, 1e-9);
  EXPECT_NEAR(boxes.front().X_PB.translation().norm(), 0, 1e-9);
}

TEST(FindTrays, PutsWallsBehindTheFacesThatAreSeen) {
  const auto boxes = FindTrays(FourWalls(), kSensor_P);
  ASSERT_FALSE(boxes.empty());
  std::array<PartOrigin, 4> sides;
  sides.fill(PartOrigin::kMeasured);
  Aabb bounds;
  for (const ShapePart& part : PartsOf(boxes.front(), sides, 0.004, PartOrigin::kMeasured)) {
    bounds.extend(TightBounds(part.shape, part.X_OS));
  }
  // Near sides show their outside, far ones their inside.
  EXPECT_NEAR(bounds.min().x(), -0.15, 1e-9);
  EXPECT_NEAR(bounds.min().y(), -0.1, 1e-9);
  EXPECT_GT(bounds.max().x(), 0.152);
  EXPECT_GT(bounds.max().y(), 0.102);
  EXPECT_NEAR(bounds.max().z(), 0.1, 1e-9);
}

TEST(FindTrays, TakesTwoOppositeWallsButNoCorner) {
  EXPECT_EQ(FindTrays({FourWalls()[0], FourWalls()[1]}, kSensor_P).size(), 1u);
  EXPECT_TRUE(FindTrays({FourWalls()[0], FourWalls()[2]}, kSensor_P).empty());
}

TEST(FindTrays, WantsRimsOfOneHeight) {
  std::vector<LoneWall> walls{FourWalls()[0], FourWalls()[1]};
  walls[1].rim_m = 0.119;
  EXPECT_EQ(FindTrays(walls, kSensor_P).size(), 1u);
  walls[1].rim_m = 0.121;
  EXPECT_TRUE(FindTrays(walls, kSensor_P).empty());
}

TEST(FindTrays, MakesOneWallOfItsPieces) {
  std::vector<LoneWall> walls = FourWalls();
  walls[3] = Wall({-0.15, 0.1}, {-0.05, 0.1});
  walls.push_back(Wall({0.03, 0.1}, {0.15, 0.1}));
  const auto boxes = FindTrays(walls, kSensor_P);
  ASSERT_FALSE(boxes.empty());
  EXPECT_EQ(boxes.front().seen_sides(), 4u);
  EXPECT_NEAR(boxes.front().size_m.maxCoeff(), 0.3, 1e-9);
}

TEST(FindTrays, FindsNoneThatAWallDivides) {
  std::vector<LoneWall> walls{FourWalls()[0], FourWalls()[1]};
  walls.push_back(Wall({-0.14, 0.02}, {0.14, 0.02}));
  EXPECT_TRUE(FindTrays(walls, kSensor_P).empty());
}

TEST(AsLoneWall, IsAThinUprightFaceTurnedToTheSensor) {
  const ShapePart thin{.X_OS = MakeTranslation(0, 0, 0.05), .shape = Box{{0.005, 0.2, 0.1}}};
  const auto wall = AsLoneWall(thin, Pose::Identity(), kSensor_P);
  ASSERT_TRUE(wall);
  EXPECT_NEAR((wall->normal - Vector2(-1, 0)).norm(), 0, 1e-9);
  EXPECT_NEAR(wall->ends[0].x(), -0.0025, 1e-9);
  EXPECT_NEAR(wall->rim_m, 0.1, 1e-9);
  const ShapePart thick{.X_OS = MakeTranslation(0, 0, 0.05), .shape = Box{{0.011, 0.2, 0.1}}};
  EXPECT_FALSE(AsLoneWall(thick, Pose::Identity(), kSensor_P));
  const ShapePart level{.X_OS = MakeTranslation(0, 0, 0.05), .shape = Box{{0.2, 0.2, 0.005}}};
  EXPECT_FALSE(AsLoneWall(level, Pose::Identity(), kSensor_P));
}

}  // namespace
}  // namespace cwm::perception
