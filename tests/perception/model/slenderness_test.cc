#include "perception/cloud/slenderness.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

namespace cwm::perception {
namespace {

constexpr double kSpacing_m = 0.001;
constexpr double kCell_m = 0.004;  // minimum cell width
const Vector3 kViewpoint(0, 0, 1);

TEST(Slenderness, OfAStripIsItsLengthAndWidth) {
  std::vector<Eigen::Vector3f> strip;
  for (double x = 0; x < 0.1; x += kSpacing_m) {
    for (double y = 0; y < 0.012; y += kSpacing_m) {
      strip.push_back(Vector3(x, y, 0).cast<float>());
    }
  }
  const Slenderness found = MeasureSlenderness(strip, kViewpoint, kSpacing_m);
  EXPECT_NEAR(found.length_m, 0.1, 2 * kCell_m);
  EXPECT_NEAR(found.width_m, 0.012, kCell_m);
}

TEST(Slenderness, FollowsABend) {
  constexpr double kRadius_m = 0.03, kWidth_m = 0.01;
  std::vector<Eigen::Vector3f> arc;
  for (double turn_rad = 0; turn_rad < std::numbers::pi; turn_rad += kSpacing_m / kRadius_m) {
    for (double r = kRadius_m - kWidth_m / 2; r < kRadius_m + kWidth_m / 2; r += kSpacing_m) {
      arc.push_back(Vector3(r * std::cos(turn_rad), r * std::sin(turn_rad), 0).cast<float>());
    }
  }
  const Slenderness found = MeasureSlenderness(arc, kViewpoint, kSpacing_m);
  // Paths over adjacent cells turn by 45 degrees and keep to the inner side: within 10 % of the
  // arc.
  EXPECT_NEAR(found.length_m, std::numbers::pi * kRadius_m, 0.1 * std::numbers::pi * kRadius_m);
  EXPECT_NEAR(found.width_m, kWidth_m, kCell_m);
}

TEST(Slenderness, IsThatOfTheStripWhenAPointLiesApart) {
  // The first of all cells; no cell of the strip can be reached from it.
  std::vector<Eigen::Vector3f> strip{{-0.02f, -0.02f, -0.02f}};
  for (double x = 0; x < 0.1; x += kSpacing_m) {
    for (double y = 0; y < 0.012; y += kSpacing_m) {
      strip.push_back(Vector3(x, y, 0).cast<float>());
    }
  }
  const Slenderness found = MeasureSlenderness(strip, kViewpoint, kSpacing_m);
  EXPECT_NEAR(found.length_m, 0.1, 2 * kCell_m);
  EXPECT_NEAR(std::abs(found.ends[0].x() - found.ends[1].x()), 0.1, 2 * kCell_m);
}

TEST(Slenderness, OfNothingIsZero) {
  EXPECT_EQ(MeasureSlenderness({}, kViewpoint, kSpacing_m).length_m, 0);
}

}  // namespace
}  // namespace cwm::perception
