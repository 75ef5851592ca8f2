#include "perception/primitive_fit/split_solids.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "tests/perception/primitive_fit/seen_on_ground.h"

namespace cwm::perception {
namespace {

// In front of the gap between the two boxes: their tops and their flush fronts are seen.
const Vector3 kFrontEye(0, -0.7, 0.7);
constexpr std::size_t kSplitPoints = 1200;
constexpr double kSideEnd_m = 0.006;  // of ends that only the top and the front show
constexpr double kTopOfPart_m = 0.002;
const Placed<> kHighBox{MakeTranslation(-0.0515, 0, 0.05), Box{{0.097, 0.08, 0.1}}};
const Placed<> kLowBox{MakeTranslation(0.0515, 0, 0.025), Box{{0.097, 0.08, 0.05}}};

// With reduced effort: its few kinds of solids are enough for boxes, and fast.
SeenOnGround AtReducedEffort(const std::vector<Placed<>>& solids) {
  SeenOnGround seen(kFrontEye, solids, kSplitPoints);
  seen.options.reduced_effort = true;
  return seen;
}

TEST(ReplaceBySplitSolids, MakesABoxOfEachOfTwoSideBySide) {
  const SeenOnGround seen = AtReducedEffort({kHighBox, kLowBox});
  Assembly assembly;
  ASSERT_TRUE(ReplaceBySplitSolids(seen.Context(), assembly));
  ASSERT_EQ(assembly.solids.size(), 2u);
  std::ranges::sort(assembly.solids, {}, [&](const Solid& s) { return seen.MiddleOf(s).x(); });
  for (std::size_t k = 0; k < 2; ++k) {
    const Placed<>& truth = k == 0 ? kHighBox : kLowBox;
    const Solid& found = assembly.solids[k];
    ASSERT_TRUE(std::holds_alternative<Box>(found.shape)) << k;
    const double height_m = 2 * truth.X_FS.translation().z();
    EXPECT_NEAR(std::get<Box>(found.shape).size_m.z(), height_m, kTopOfPart_m) << k;
    EXPECT_NEAR(std::get<Box>(found.shape).size_m.head<2>().prod(), 0.097 * 0.08,
                2 * 0.1 * kSideEnd_m)
        << k;
    EXPECT_LT((seen.MiddleOf(found) - truth.X_FS.translation()).norm(), kSideEnd_m) << k;
    EXPECT_GT(found.inliers.size(), kSplitPoints * 9 / 20) << k;
  }
}

TEST(ReplaceBySplitSolids, CutsNoBoxInTwo) {
  const SeenOnGround seen =
      AtReducedEffort({{MakeTranslation(0, 0, 0.025), Box{{0.2, 0.08, 0.05}}}});
  Assembly unknown;
  EXPECT_FALSE(ReplaceBySplitSolids(seen.Context(), unknown));
  EXPECT_TRUE(unknown.solids.empty());
  const Solid box = seen.Assembled({MakeTranslation(0, 0, 0.025), Box{{0.2, 0.08, 0.05}}});
  Assembly known{{box}, {}};
  EXPECT_FALSE(ReplaceBySplitSolids(seen.Context(), known));
  ASSERT_EQ(known.solids.size(), 1u);
  EXPECT_EQ(known.solids.front().shape, box.shape);
}

TEST(ReplaceBySplitSolids, AsksForTheOptionAndForAGround) {
  SeenOnGround seen = AtReducedEffort({kHighBox, kLowBox});
  Assembly assembly;
  FitContext nowhere = seen.Context();
  nowhere.ground.known = false;
  EXPECT_FALSE(ReplaceBySplitSolids(nowhere, assembly));
  seen.options.split_touching = false;
  EXPECT_FALSE(ReplaceBySplitSolids(seen.Context(), assembly));
  EXPECT_TRUE(assembly.solids.empty());
}

}  // namespace
}  // namespace cwm::perception
