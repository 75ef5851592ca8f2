#include "collision/geometry/polygon.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace cwm {
namespace {

// A star-shaped, mostly concave polygon.
Polygon RandomStar(std::mt19937& random, int count, const Vector2& centre, double radius) {
  std::uniform_real_distribution<double> share(0.3, 1);
  Polygon polygon;
  for (int i = 0; i < count; ++i) {
    const double angle = 2 * std::numbers::pi * i / count;
    polygon.push_back(centre + radius * share(random) * Vector2(std::cos(angle), std::sin(angle)));
  }
  return polygon;
}

TEST(Polygon, SquareHasItsAreaAndBorder) {
  const Polygon square = {{0, 0}, {2, 0}, {2, 2}, {0, 2}};
  EXPECT_EQ(SignedArea_m2(square), 4);
  EXPECT_TRUE(Contains(square, {1, 1}));
  EXPECT_FALSE(Contains(square, {3, 1}));
  EXPECT_EQ(NearestOnBorder(square, {1, -1}), Vector2(1, 0));
}

TEST(Polygon, KnowsCrossedFoldedAndTouchingBorders) {
  EXPECT_TRUE(IsSimple({{0, 0}, {1, 0}, {2, 0}, {2, 2}}));  // a corner of 180 degrees is allowed
  EXPECT_FALSE(IsSimple({{0, 0}, {1, 1}, {1, 0}, {0, 1}}));
  EXPECT_FALSE(IsSimple({{0, 0}, {2, 0}, {1, 0}, {1, 1}}));
  EXPECT_FALSE(IsSimple({{0, 0}, {2, 0}, {2, 2}, {1, 0}, {0, 2}}));
  EXPECT_FALSE(IsSimple({{0, 0}, {1, 0}, {1, 0}, {0, 1}}));
  EXPECT_FALSE(IsSimple({{0, 0}, {1, 0}}));
}

TEST(Polygon, PiecesOfARegionWithHolesCoverItExactly) {
  std::mt19937 random(5);
  for (int k = 0; k < 200; ++k) {
    const Polygon outline = RandomStar(random, 8 + k % 40, {0, 0}, 10);
    std::vector<Polygon> holes;
    for (int h = 0; h < k % 4; ++h) {
      const double angle = 2.1 * h;
      holes.push_back(
          RandomStar(random, 3 + k % 9, 1.5 * Vector2(std::cos(angle), std::sin(angle)), 0.9));
    }
    if (!IsSimpleRegion(outline, holes)) continue;
    double area = SignedArea_m2(outline), triangles = 0, pieces = 0;
    for (const Polygon& hole : holes) area -= std::abs(SignedArea_m2(hole));
    for (const auto& [a, b, c] : Triangulate(outline, holes)) {
      EXPECT_GT(SignedArea_m2({a, b, c}), 0) << k;
      triangles += SignedArea_m2({a, b, c});
    }
    for (const Polygon& piece : ConvexPieces(outline, holes)) {
      EXPECT_EQ(ConvexHull(piece).size(), piece.size()) << k;
      pieces += SignedArea_m2(piece);
    }
    EXPECT_NEAR(triangles, area, 1e-11) << k;
    EXPECT_NEAR(pieces, area, 1e-11) << k;
  }
}

TEST(Polygon, ConvexOutlineIsOnePiece) {
  EXPECT_EQ(ConvexPieces({{0, 0}, {2, 0}, {2, 2}, {0, 2}}, {}).size(), 1u);
  EXPECT_TRUE(ConvexPieces({{0, 0}, {1, 1}, {1, 0}, {0, 1}}, {}).empty());
}

}  // namespace
}  // namespace cwm
