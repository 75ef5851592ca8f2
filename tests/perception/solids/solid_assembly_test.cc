#include "perception/solids/solid_assembly.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/perception/solids/seen_fits.h"

namespace cwm::perception {
namespace {

// A block whose top is seen from straight above.
struct SeenBlock {
  SeenBlock() {
    solid.shape = Box{{0.2, 0.2, 0.1}};
    solid.X_MS.translation().z() = -0.05;
    solid.inliers = seen.AddFace({-0.04, -0.04, 0}, {0.08, 0, 0}, {0, 0.08, 0}).inliers;
  }
  SeenFits seen{Vector3(0, 0, 1)};
  Solid solid;
};

// Merged views show free space to nobody: what is filled, they show by its sides.
TEST(IsCrossed, WithoutRaysUnlessMostOfTheSurfaceIsSeen) {
  SeenBlock block;
  block.seen.options.from_viewpoint = false;
  EXPECT_TRUE(IsCrossed(block.solid, block.seen.Context())) << "a part of the top alone is seen";
  block.seen.AddFace({-0.1, -0.1, 0}, {0.2, 0, 0}, {0, 0.2, 0});
  block.seen.AddFace({-0.1, -0.1, -0.1}, {0.2, 0, 0}, {0, 0, 0.1});
  block.seen.AddFace({-0.1, 0.1, -0.1}, {0.2, 0, 0}, {0, 0, 0.1});
  block.seen.AddFace({-0.1, -0.1, -0.1}, {0, 0.2, 0}, {0, 0, 0.1});
  EXPECT_FALSE(IsCrossed(block.solid, block.seen.Context())) << "the top and three sides are seen";
  for (int k = 0; k < 400; ++k) {
    block.seen.AddPoint({0.0002 * k, 0, -0.05}, Vector3::UnitZ());
  }
  EXPECT_TRUE(IsCrossed(block.solid, block.seen.Context())) << "points lie in it";
}

// A twentieth of its 441 points, and three more, may be measured inside the block; as many rays may
// cross it.
TEST(IsCrossed, ByMoreRaysThanMixedPixelsExplain) {
  SeenBlock block;
  for (int k = 0; k < 20; ++k) block.seen.AddPoint({0.002 * k, 0, -0.05}, Vector3::UnitZ());
  EXPECT_FALSE(IsCrossed(block.solid, block.seen.Context()));
  for (int k = 0; k < 20; ++k) block.seen.AddPoint({0.002 * k, 0.01, -0.05}, Vector3::UnitZ());
  EXPECT_TRUE(IsCrossed(block.solid, block.seen.Context()));
  SeenBlock passed;
  FreeRays free;
  const auto add = [&](int rays) {
    for (int k = 0; k < rays; ++k) {
      free.rays.push_back(RayBetween({-0.3, 0.001 * k, -0.05}, {0.3, 0.001 * k, -0.05}));
    }
  };
  add(20);
  EXPECT_FALSE(IsCrossed(passed.solid, passed.seen.Context({}, free)));
  add(10);
  EXPECT_TRUE(IsCrossed(passed.solid, passed.seen.Context({}, free)));
}

TEST(AssembleSolids, GivesACanItsLidAndABoxItsFaces) {
  SeenFits seen(Vector3(-0.6, -0.4, 0.7));
  const CylinderModel can{.point = Vector3(0, 0.2, 0), .radius_m = 0.04};
  Extraction extraction;
  extraction.notes = {"a cap fired"};
  extraction.fits = {seen.AddFace({-0.06, -0.14, 0.06}, {0.12, 0, 0}, {0, 0.08, 0}),
                     seen.Fit(can, seen.AddWall(can.AsCone(), 0, 0.1)),
                     seen.AddDisc({0, 0.2, 0.1}, 0.04),
                     seen.AddFace({-0.06, -0.06, 0}, {0, -0.08, 0}, {0, 0, 0.06}),
                     seen.AddFace({-0.06, -0.14, 0}, {0.12, 0, 0}, {0, 0, 0.06})};
  const Assembly assembly = AssembleSolids(extraction, seen.Context(), Ground());
  ASSERT_EQ(assembly.solids.size(), 2u);
  ASSERT_TRUE(std::holds_alternative<Cylinder>(assembly.solids[0].shape)) << "round ones first";
  EXPECT_NEAR(std::get<Cylinder>(assembly.solids[0].shape).length_m, 0.1, kSeenEnd_m);
  ASSERT_TRUE(std::holds_alternative<Box>(assembly.solids[1].shape));
  const Vector3 off_m = std::get<Box>(assembly.solids[1].shape).size_m - Vector3(0.12, 0.08, 0.06);
  EXPECT_LT(off_m.cwiseAbs().maxCoeff(), kSeenEnd_m);
  EXPECT_EQ(assembly.solids[0].inliers.size() + assembly.solids[1].inliers.size(), seen.size());
  EXPECT_EQ(assembly.notes, extraction.notes);
  EXPECT_TRUE(AssembleSolids({}, seen.Context(), Ground()).solids.empty());
}

// The sensor looks over the near rim of a mug at its inner wall.
TEST(AssembleSolids, FillsNoWallThatIsSeenFromBothSides) {
  SeenFits seen(Vector3(-0.6, 0, 0.6));
  const CylinderModel outer{.radius_m = 0.04};
  Extraction extraction;
  extraction.fits = {seen.Fit(outer, seen.AddWall(outer.AsCone(), 0, 0.1))};
  EXPECT_EQ(AssembleSolids(extraction, seen.Context(), Ground()).solids.size(), 1u);
  seen.AddWall({.radius_m = 0.036, .side = SeenFrom::kInside}, 0.05, 0.1);
  const Assembly assembly = AssembleSolids(extraction, seen.Context(), Ground());
  EXPECT_TRUE(assembly.solids.empty());
  EXPECT_EQ(assembly.notes, std::vector<std::string>{std::string(kSeenFromBothSides)});
}

TEST(AssembleSolids, LeavesALoneFaceThatIsSmallInItsObject) {
  for (const double side_m : {0.03, 0.1}) {
    SeenFits seen(Vector3(0, 0, 1.3));
    Extraction extraction;
    extraction.fits = {seen.AddFace({-0.1, -0.1, 0.3}, {0.2, 0, 0}, {0, 0.2, 0}),
                       seen.AddFace({0.3, 0, 0.3}, {side_m, 0, 0}, {0, side_m, 0})};
    const std::vector<Solid> solids = AssembleSolids(extraction, seen.Context(), Ground()).solids;
    ASSERT_EQ(solids.size(), side_m < 0.05 ? 1u : 2u) << side_m;
    EXPECT_EQ(solids[0].inliers, extraction.fits[0].inliers);
  }
}

}  // namespace
}  // namespace cwm::perception
