#include "perception/solids/extent_from_points.h"

#include <gtest/gtest.h>

#include "collision/geometry/aabb.h"
#include "tests/perception/solids/seen_fits.h"

namespace cwm::perception {
namespace {

Solid PlacedAt(const Vector3& middle, const Shape& shape) {
  Solid solid;
  solid.X_MS.translation() = middle;
  solid.shape = shape;
  return solid;
}

Aabb BoundsOf(const Solid& solid) { return TightBounds(solid.shape, solid.X_MS); }

// A bar along x whose top is seen from -5 to 5 cm and from 7 to 15 cm, with something between them.
// The solid is made of the first piece.
struct HalfOfABar {
  HalfOfABar() {
    seen.AddFace({-0.05, -0.025, 0.06}, {0.1, 0, 0}, {0, 0.05, 0});
    beyond = seen.AddFace({0.07, -0.025, 0.06}, {0.08, 0, 0}, {0, 0.05, 0}).inliers;
  }
  std::vector<Solid> Reached(std::vector<Solid> solids, const FreeRays& free = {}) {
    SetExtentFromPoints(seen.Context({}, free), solids);
    return solids;
  }

  SeenFits seen{Vector3(0, -0.6, 0.6)};
  std::vector<std::uint32_t> beyond;
  const Solid piece = PlacedAt({0, 0, 0.03}, Box{{0.1, 0.05, 0.06}});
};

// A ray across the bar below its top, at this place along it.
FreeRay RayAcross(double x_m) { return RayBetween({x_m, -0.2, 0.03}, {x_m, 0.2, 0.03}); }

TEST(SetExtentFromPoints, ExtendsABoxToWhereItIsSeenAgainUnlessRaysRunThrough) {
  HalfOfABar bar;
  const Solid whole = bar.Reached({bar.piece}).front();
  EXPECT_LT((BoundsOf(whole).min() - BoundsOf(bar.piece).min()).norm(), kSeenExact_m);
  EXPECT_NEAR(BoundsOf(whole).max().x(), 0.15, kSeenEnd_m);
  EXPECT_NEAR(BoundsOf(whole).max().y(), 0.025, kSeenExact_m);
  EXPECT_NEAR(BoundsOf(whole).max().z(), 0.06, kSeenExact_m);
  EXPECT_EQ(whole.inliers, bar.beyond);
  FreeRays free;
  for (int k = 0; k < 45; ++k) free.rays.push_back(RayAcross(0.3 + 0.001 * k));
  EXPECT_NEAR(BoundsOf(bar.Reached({bar.piece}, free).front()).max().x(), 0.15, kSeenEnd_m);
  for (int k = 0; k < 5; ++k) free.rays.push_back(RayAcross(0.058 + 0.001 * k));
  EXPECT_EQ(bar.Reached({bar.piece}, free).front().shape, bar.piece.shape);
}

TEST(SetExtentFromPoints, LeavesThePointsOfOtherSolidsAndNoSolidsAlone) {
  HalfOfABar bar;
  const Solid other = PlacedAt({0.11, 0, 0.03}, Box{{0.08, 0.05, 0.06}});
  const std::vector<Solid> both = bar.Reached({bar.piece, other});
  EXPECT_EQ(both[0].shape, bar.piece.shape);
  EXPECT_EQ(both[1].shape, other.shape);
  EXPECT_TRUE(bar.Reached({}).empty());
}

// A wall that continues below the foot of its solid, down to 5 cm below the origin.
TEST(SetExtentFromPoints, ReachesDownToTheGroundAndNotBelow) {
  for (const double ground_m : {-0.05, 0.0}) {
    SeenFits seen(Vector3(0, -0.6, 0.6));
    seen.AddFace({-0.05, -0.01, -0.05}, {0.1, 0, 0}, {0, 0, 0.05});
    std::vector<Solid> solids = {PlacedAt({0, 0, 0.035}, Box{{0.1, 0.02, 0.05}})};
    SetExtentFromPoints(seen.Context({.known = true, .point = Vector3(0, 0, ground_m)}), solids);
    EXPECT_NEAR(BoundsOf(solids[0]).min().z(), ground_m < 0 ? -0.05 : 0.01, kSeenEnd_m);
    EXPECT_NEAR(BoundsOf(solids[0]).max().z(), 0.06, kSeenExact_m);
  }
}

TEST(SetExtentFromPoints, ExtendsACanToItsWallAndNotToAnInnerOne) {
  for (const SeenFrom side : {SeenFrom::kOutside, SeenFrom::kInside}) {
    SeenFits seen(Vector3(0, -0.6, 0.6));
    seen.AddWall({.radius_m = 0.03, .side = side}, 0.08, 0.14);
    std::vector<Solid> solids = {PlacedAt({0, 0, 0.03}, Cylinder{0.03, 0.06})};
    SetExtentFromPoints(seen.Context(), solids);
    EXPECT_NEAR(BoundsOf(solids[0]).min().z(), 0, kSeenExact_m);
    EXPECT_NEAR(BoundsOf(solids[0]).max().z(), side == SeenFrom::kOutside ? 0.14 : 0.06,
                kSeenEnd_m);
  }
}

}  // namespace
}  // namespace cwm::perception
