// How far points reach along a direction.
#include <gtest/gtest.h>

#include <cstdint>
#include <numeric>
#include <random>
#include <vector>

#include "perception/fit/solid.h"

namespace cwm::perception {
namespace {

constexpr double kLength_m = 0.2;
// Half of the 4 mm bins in which points are counted, and a whole bin where points are few.
constexpr double kHalfBin_m = 0.002, kBin_m = 0.004;

// Points on the x axis from 0 to kLength_m with noise of 2 mm. The density at the far end is `far`
// times the density at the near end.
ModelPoints Fading(double far, int count) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(0, 1);
  std::normal_distribution<double> noise(0, 0.002);
  ModelPoints points;
  while (static_cast<int>(points.p.size()) < count) {
    const double at = uniform(random);
    if (uniform(random) > 1 - (1 - far) * at) continue;
    points.p.emplace_back(kLength_m * at + noise(random), 0, 0);
  }
  return points;
}

Interval AlongX(const ModelPoints& points, Density density) {
  std::vector<std::uint32_t> all(points.p.size());
  std::iota(all.begin(), all.end(), 0U);
  return ExtentAlong(Vector3::UnitX(), points, all, density);
}

TEST(ExtentAlong, EndsWhereASharpEdgeWouldHoldThePoints) {
  const ModelPoints even = Fading(1, 4000);
  for (const Density density : {Density::kEven, Density::kFading}) {
    const Interval extent = AlongX(even, density);
    EXPECT_NEAR(extent.low_m, 0, kHalfBin_m);
    EXPECT_NEAR(extent.high_m, kLength_m, kHalfBin_m);
  }
}

TEST(ExtentAlong, ReachesTheFarEndOfAFaceThatLeadsAway) {
  const ModelPoints fading = Fading(0.25, 4000);
  EXPECT_LT(AlongX(fading, Density::kEven).high_m, kLength_m - 1.5 * kBin_m)
      << "as of even density";
  EXPECT_NEAR(AlongX(fading, Density::kFading).high_m, kLength_m, kBin_m);
  EXPECT_NEAR(AlongX(fading, Density::kFading).low_m, 0, kBin_m);
}

TEST(ExtentAlong, IsNotLedOnByStrayPointsBeyondAnEnd) {
  ModelPoints points = Fading(0.5, 4000);
  for (int i = 0; i < 40; ++i) points.p.emplace_back(kLength_m + 0.001 * i, 0, 0);
  EXPECT_NEAR(AlongX(points, Density::kFading).high_m, kLength_m, kBin_m);
}

}  // namespace
}  // namespace cwm::perception
