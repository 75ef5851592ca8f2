#include "perception/outline_raster.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace cwm::perception {
namespace {

// A star with arms of random lengths: concave, with edges in all directions.
Polygon Star(std::mt19937& random) {
  std::uniform_real_distribution<double> radius_m(0.1, 1.5);
  const int corners = 3 + static_cast<int>(random() % 30);
  Polygon star;
  for (int i = 0; i < corners; ++i) {
    const double angle_rad = 2 * std::numbers::pi * i / corners;
    star.push_back(radius_m(random) * Vector2(std::cos(angle_rad), std::sin(angle_rad)));
  }
  return star;
}

TEST(OutlineRaster, SaysTheSameAsThePolygon) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> place_m(-1.6, 1.6);
  for (int round = 0; round < 100; ++round) {
    const Polygon outline = Star(random);
    const OutlineRaster raster(outline);
    for (int k = 0; k < 2000; ++k) {
      const Vector2 p(place_m(random), place_m(random));
      ASSERT_EQ(raster.Contains(p), Contains(outline, p)) << "round " << round << ", point " << k;
    }
  }
}

TEST(OutlineRaster, SaysTheSameAsARectangleWhoseEdgesRunAlongItsCells) {
  const Polygon outline = {{0, 0}, {0.8, 0}, {0.8, 0.4}, {0, 0.4}};
  const OutlineRaster raster(outline);
  for (double x = -0.1003; x < 0.9; x += 0.007) {
    for (double y = -0.1003; y < 0.5; y += 0.007) {
      ASSERT_EQ(raster.Contains({x, y}), Contains(outline, {x, y})) << x << ", " << y;
    }
  }
}

}  // namespace
}  // namespace cwm::perception
