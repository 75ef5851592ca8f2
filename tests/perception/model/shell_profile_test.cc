#include "perception/vessels/shell_profile.h"

#include <gtest/gtest.h>

namespace cwm::perception {
namespace {

constexpr double kStep_m = 0.006, kThickness_m = 0.004;

// The outline of a straight wall of 40 mm radius between two heights.
ShellOutline Wall(double low_m, double high_m) {
  ShellOutline outline{.step_m = kStep_m, .rim_z_m = high_m, .thickness_m = kThickness_m};
  for (double z_m = low_m; z_m < high_m; z_m += kStep_m) {
    outline.rings.push_back(
        {.z_m = z_m, .radius_m = 0.04, .weight = 20, .shows_outside = true, .shows_inside = true});
  }
  outline.floor = {{0.03, 0.006}, {0.015, 0.006}};
  outline.ground_z_m = 0;
  return outline;
}

TEST(MakeShell, OfAMugHasTheWallTheRimAndTheFloorThatWereSeen) {
  const auto made = MakeShell(Wall(0.005, 0.1));
  ASSERT_TRUE(made);
  EXPECT_NEAR(made->shell.rim_radius_m(), 0.04, 1e-12);
  EXPECT_NEAR(made->shell.height_m(), 0.1, 1e-12);
  EXPECT_NEAR(made->shell.depth_m(), 0.094, 1e-12);
  EXPECT_NEAR(made->middle_z_m, 0.05, 1e-12);
  EXPECT_NEAR(SignedDistance_m(made->shell, {0.038, 0, 0}), -0.002, 1e-9);
  EXPECT_GT(SignedDistance_m(made->shell, {0, 0, 0}), 0.03);
  EXPECT_GT(made->measured_share, 0.9);
}

TEST(MakeShell, SuppliesAFloorAsThickAsTheWallWhereNoneWasSeen) {
  ShellOutline outline = Wall(0.05, 0.1);
  outline.floor.clear();
  const auto made = MakeShell(outline);
  ASSERT_TRUE(made);
  EXPECT_NEAR(made->shell.height_m(), 0.1, 1e-12);
  EXPECT_NEAR(made->shell.depth_m(), 0.1 - kThickness_m, 1e-12);
  EXPECT_LT(made->measured_share, 0.6);
}

TEST(MakeShell, EndsWhereItWasSeenWhereRaysPassedBelow) {
  ShellOutline outline = Wall(0.05, 0.1);
  outline.floor.clear();
  outline.foot = ShellFoot::kAtSeenEnd;
  const auto made = MakeShell(outline);
  ASSERT_TRUE(made);
  EXPECT_NEAR(made->shell.height_m(), 0.05, 1e-12);
  outline = Wall(0.02, 0.1);  // the band of a support, and the part in the shadow of the foot
  outline.foot = ShellFoot::kAtSeenEnd;
  ASSERT_TRUE(MakeShell(outline));
  EXPECT_NEAR(MakeShell(outline)->shell.height_m(), 0.1, 1e-12);
}

TEST(MakeShell, NeverEntersTheGround) {
  ShellOutline outline = Wall(0.005, 0.1);
  outline.floor = {{0.03, -0.002}, {0.015, -0.002}};  // noise
  const auto made = MakeShell(outline);
  ASSERT_TRUE(made);
  EXPECT_NEAR(made->middle_z_m + made->shell.outer.front().y(), 0, 1e-12);
  EXPECT_GT(made->middle_z_m + made->shell.inner.back().y(), 0);
}

TEST(MakeShell, NarrowsUnderABowlAsItsInsideDoes) {
  ShellOutline bowl{.step_m = kStep_m, .rim_z_m = 0.07, .thickness_m = kThickness_m};
  for (double z_m = 0.04; z_m < 0.07; z_m += kStep_m) {
    bowl.rings.push_back({.z_m = z_m,
                          .radius_m = 0.06 + 0.5 * (z_m - 0.04),
                          .slope = 0.5,
                          .weight = 20,
                          .shows_inside = true});
  }
  for (double radial_m = 0.05; radial_m > 0; radial_m -= 0.01) {
    bowl.floor.emplace_back(radial_m, 0.01 + 10 * radial_m * radial_m);
  }
  bowl.ground_z_m = 0;
  const auto made = MakeShell(bowl);
  ASSERT_TRUE(made);
  EXPECT_LT(made->shell.foot_radius_m(), 0.045);
  EXPECT_NEAR(made->shell.rim_radius_m(), 0.075, 0.001);
  // The wall is about equally thick everywhere.
  const Vector3 middle(0.04, 0, 0.01 + 10 * 0.04 * 0.04 - made->middle_z_m);
  EXPECT_NEAR(SignedDistance_m(made->shell, middle), 0, 0.002);
  EXPECT_LT(SignedDistance_m(made->shell, middle - Vector3(0, 0, 0.002)), 0);
  EXPECT_GT(SignedDistance_m(made->shell, middle - Vector3(0, 0, 0.012)), 0);
}

TEST(MakeShell, OfNothingDeepIsNone) {
  ShellOutline outline = Wall(0.005, 0.1);
  outline.floor = {{0.03, 0.097}};
  EXPECT_FALSE(MakeShell(outline));
}

}  // namespace
}  // namespace cwm::perception
