#include "perception/solids/plane_solid.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/perception/solids/seen_fits.h"

namespace cwm::perception {
namespace {

const Vector3 kAbove(0, 0, 1.3);

TEST(SmallestRectangle, HasAnEdgeAlongOneOfTheOutline) {
  const Vector2 middle(1, 2), x(std::cos(0.4), std::sin(0.4)), y(-x.y(), x.x());
  // A rectangle of 20 by 10 cm without one of its corners.
  const Polygon hull = {middle - 0.1 * x - 0.05 * y, middle + 0.1 * x - 0.05 * y,
                        middle + 0.1 * x + 0.03 * y, middle + 0.08 * x + 0.05 * y,
                        middle - 0.1 * x + 0.05 * y};
  const Rectangle found = SmallestRectangle(hull);
  EXPECT_NEAR(found.area_m2(), 0.02, kSeenExact_m);
  EXPECT_LT((found.center() - middle).norm(), kSeenExact_m);
  EXPECT_NEAR(std::abs(found.x.dot(x) * found.x.dot(y)), 0, kSeenExact_m);
}

TEST(MakePlaneSolid, IsAsDeepAsTheGroundOrASideTellsAndElseThin) {
  for (const double height_m : {0.3, 0.03}) {
    SeenFits seen(kAbove);
    const ShapeFit face = seen.AddFace({-0.1, -0.05, height_m}, {0.2, 0, 0}, {0, 0.1, 0});
    const auto solid = MakePlaneSolid(face, seen.Context(kFloorAtZero), kFloorAtZero);
    ASSERT_TRUE(solid && std::holds_alternative<Box>(solid->shape));
    const double depth_m = height_m < kLowLevel_m ? height_m : kLoneThickness_m;
    const Vector3 size_m = std::get<Box>(solid->shape).size_m;
    EXPECT_NEAR(size_m.x(), 0.2, 2 * kSeenEnd_m);
    EXPECT_NEAR(size_m.z(), depth_m, kSeenExact_m);
    EXPECT_NEAR(solid->X_MS.translation().z(), height_m - 0.5 * depth_m, kSeenExact_m);
    EXPECT_EQ(IsLoneFace(solid->shape), depth_m == kLoneThickness_m);
    EXPECT_EQ(solid->inliers, face.inliers);
  }
  // The side below the top is visible 4 cm down, but is not a face of its own.
  SeenFits seen(Vector3(-0.5, 0, 0.6));
  const ShapeFit top = seen.AddFace({-0.06, -0.04, 0.3}, {0.12, 0, 0}, {0, 0.08, 0});
  seen.AddFace({-0.06, 0.04, 0.26}, {0, -0.08, 0}, {0, 0, 0.04});
  const auto solid = MakePlaneSolid(top, seen.Context(), Ground());
  ASSERT_TRUE(solid && std::holds_alternative<Box>(solid->shape));
  const Vector3 size_m = std::get<Box>(solid->shape).size_m;
  EXPECT_NEAR(size_m.z(), 0.04, kSeenExact_m);
  EXPECT_NEAR(solid->X_MS.translation().z(), 0.28, kSeenExact_m);
  EXPECT_NEAR(solid->X_MS.translation().x() - 0.5 * size_m.x(), -0.06, kSeenExact_m);
}

TEST(MakePlaneSolid, StandsAnUprightFaceOnTheGroundAndMakesNothingOfOneBelow) {
  SeenFits seen(Vector3(-0.6, 0, 0.4));
  const ShapeFit above = seen.AddFace({0, 0.05, 0.02}, {0, -0.1, 0}, {0, 0, 0.1});
  const auto solid = MakePlaneSolid(above, seen.Context(kFloorAtZero), kFloorAtZero);
  ASSERT_TRUE(solid && std::holds_alternative<Box>(solid->shape));
  const Vector3 size_m = std::get<Box>(solid->shape).size_m;
  EXPECT_NEAR(size_m.x(), kLoneThickness_m, kSeenExact_m);
  EXPECT_NEAR(solid->X_MS.translation().x(), 0.5 * kLoneThickness_m, kSeenExact_m) << "behind it";
  EXPECT_NEAR(solid->X_MS.translation().z(), 0.5 * size_m.z(), kSeenExact_m) << "on the ground";
  EXPECT_NEAR(size_m.z(), 0.12, kSeenEnd_m);
  const ShapeFit below = seen.AddFace({0, 0.05, -0.1}, {0, -0.1, 0}, {0, 0, 0.08});
  EXPECT_FALSE(MakePlaneSolid(below, seen.Context(kFloorAtZero), kFloorAtZero));
}

TEST(MakePlaneSolid, IsAPlateOverARoundFaceAndNothingOverAFrameThatRaysPass) {
  SeenFits round(kAbove);
  const ShapeFit disc = round.AddDisc({0.02, 0, 0.3}, 0.06);
  const auto solid = MakePlaneSolid(disc, round.Context(), Ground());
  ASSERT_TRUE(solid && std::holds_alternative<Plate>(solid->shape));
  const Plate& plate = std::get<Plate>(solid->shape);
  const double area_m2 = std::numbers::pi * 0.06 * 0.06;
  EXPECT_LE(SignedArea_m2(plate.outline), area_m2);
  EXPECT_GT(SignedArea_m2(plate.outline), 0.95 * area_m2);
  EXPECT_EQ(plate.thickness_m, kLoneThickness_m);
  EXPECT_NEAR(solid->X_MS.translation().z(), 0.3, kSeenExact_m) << "a plate's top is its face";
  // Only the border of a frame of 20 by 10 cm is seen.
  SeenFits seen(kAbove);
  std::vector<std::uint32_t> border;
  const auto add = [&](double x, double y) {
    border.push_back(seen.AddPoint({x, y, 0.3}, Vector3::UnitZ()));
  };
  for (int k = 0; k <= 50; ++k) add(-0.1 + 0.004 * k, -0.05), add(-0.1 + 0.004 * k, 0.05);
  for (int k = 1; k < 25; ++k) add(-0.1, -0.05 + 0.004 * k), add(0.1, -0.05 + 0.004 * k);
  const ShapeFit frame = seen.Fit(PlaneModel{.point = Vector3(0, 0, 0.3)}, border);
  const auto made = [&](const FreeRays& free) {
    return MakePlaneSolid(frame, seen.Context({}, free), Ground()).has_value();
  };
  const auto ray_at = [](double x) { return RayBetween({x, 0, 0.5}, {x, 0, 0.1}); };
  FreeRays free;
  EXPECT_FALSE(made(free));
  for (int k = 0; k < 20; ++k) free.rays.push_back(ray_at(0.5 + 0.01 * k));
  EXPECT_TRUE(made(free)) << "something hides its middle";
  for (int k = 0; k < 5; ++k) free.rays.push_back(ray_at(0.01 * k));
  EXPECT_FALSE(made(free));
}

}  // namespace
}  // namespace cwm::perception
