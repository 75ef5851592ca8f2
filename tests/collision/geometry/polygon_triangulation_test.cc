#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <numbers>
#include <random>

#include "collision/geometry/polygon.h"
#include "collision/geometry/validation.h"

namespace cwm {
namespace {

Polygon Star(std::mt19937& random, int count, const Vector2& centre, double radius,
             double min_share) {
  std::uniform_real_distribution<double> share(min_share, 1);
  Polygon polygon;
  for (int i = 0; i < count; ++i) {
    const double angle = 2 * std::numbers::pi * i / count;
    polygon.push_back(centre + radius * share(random) * Vector2(std::cos(angle), std::sin(angle)));
  }
  if (count % 2 == 1) std::reverse(polygon.begin(), polygon.end());  // both orientations
  return polygon;
}

struct Region {
  Polygon outline;
  std::vector<Polygon> holes;

  double area_m2() const {
    double area = std::abs(SignedArea_m2(outline));
    for (const Polygon& hole : holes) area -= std::abs(SignedArea_m2(hole));
    return area;
  }
  bool Holds(const Vector2& p) const {
    return Contains(outline, p) && std::none_of(holes.begin(), holes.end(),
                                                [&](const Polygon& h) { return Contains(h, p); });
  }
  double DistanceToBorder_m(const Vector2& p) const {
    double least = (NearestOnBorder(outline, p) - p).norm();
    for (const Polygon& hole : holes)
      least = std::min(least, (NearestOnBorder(hole, p) - p).norm());
    return least;
  }
};

// A concave outline with concave holes around the corners of a hexagon.
Region RandomRegion(std::mt19937& random, int corners, int holes) {
  Region region{Star(random, corners, {0, 0}, 2, 0.75), {}};
  for (int i = 0; i < holes; ++i) {
    const double angle = 2 * std::numbers::pi * i / holes;
    region.holes.push_back(
        Star(random, 5 + i, 0.9 * Vector2(std::cos(angle), std::sin(angle)), 0.4, 0.3));
  }
  return region;
}

TEST(Triangulate, CoversRandomRegionsByArea) {
  std::mt19937 random(3);
  for (int k = 0; k < 100; ++k) {
    const Region region = RandomRegion(random, 8 + k, k % 7);
    ASSERT_TRUE(IsSimpleRegion(region.outline, region.holes)) << k;
    double area = 0;
    for (const auto& t : Triangulate(region.outline, region.holes)) {
      const double part = SignedArea_m2({t[0], t[1], t[2]});
      EXPECT_GE(part, 0);
      area += part;
    }
    EXPECT_NEAR(area, region.area_m2(), 1e-12 * region.area_m2()) << k;
  }
}

TEST(ConvexPieces, HoldExactlyThePointsOfRandomRegions) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> place(-2, 2);
  for (int k = 0; k < 60; ++k) {
    const Region region = RandomRegion(random, 6 + k, k % 7);
    const std::vector<Polygon> pieces = ConvexPieces(region.outline, region.holes);
    double area = 0;
    for (const Polygon& piece : pieces) {
      area += SignedArea_m2(piece);
      for (std::size_t i = 0; i < piece.size(); ++i) {
        const Vector2 u = piece[(i + 1) % piece.size()] - piece[i];
        const Vector2 v = piece[(i + 2) % piece.size()] - piece[i];
        EXPECT_GE(u.x() * v.y() - u.y() * v.x(), -1e-15);
      }
    }
    EXPECT_NEAR(area, region.area_m2(), 1e-12 * region.area_m2()) << k;
    for (int i = 0; i < 300; ++i) {
      const Vector2 p(place(random), place(random));
      if (region.DistanceToBorder_m(p) < 1e-9) continue;
      const auto holders = std::count_if(pieces.begin(), pieces.end(),
                                         [&](const Polygon& piece) { return Contains(piece, p); });
      // A point within rounding of a diagonal may count for both sides or for neither.
      ASSERT_EQ(holders, region.Holds(p) ? 1 : 0) << k << " " << p.transpose();
    }
  }
}

TEST(ConvexPieces, OfAConvexOutlineAreTheOutline) {
  const Polygon clockwise = {{0, 0}, {0, 1}, {1, 1}, {2, 0}, {1, 0}};
  const std::vector<Polygon> pieces = ConvexPieces(clockwise, {});
  ASSERT_EQ(pieces.size(), 1u);
  EXPECT_EQ(SignedArea_m2(pieces[0]), 1.5);
}

TEST(ConvexPieces, OfAThousandVerticesTakeMilliseconds) {
  std::mt19937 random(5);
  const Region concave = RandomRegion(random, 1000, 6);
  Polygon circle;
  for (int i = 0; i < kMaxPlateVertices; ++i) {
    const double angle = 2 * std::numbers::pi * i / kMaxPlateVertices;
    circle.emplace_back(std::cos(angle), std::sin(angle));
  }
  const auto start = std::chrono::steady_clock::now();
  EXPECT_GT(ConvexPieces(concave.outline, concave.holes).size(), 100u);
  EXPECT_EQ(ConvexPieces(circle, {}).size(), 1u);
  const auto elapsed = std::chrono::steady_clock::now() - start;
  RecordProperty(
      "elapsed_us",
      static_cast<int>(std::chrono::duration_cast<std::chrono::microseconds>(elapsed).count()));
  EXPECT_LT(elapsed, std::chrono::seconds(1));  // measured: a few milliseconds
}

TEST(Validation, RefusesPlatesOfTooManyVerticesBeforeLookingAtThem) {
  Plate plate{.outline = Polygon(100000, Vector2(0, 0)), .holes = {}, .thickness_m = 0.1};
  const auto violation = FindViolation(Shape(plate));
  ASSERT_TRUE(violation.has_value());
  EXPECT_EQ(violation->field, "outline");
  EXPECT_EQ(violation->value, "100000 vertices");
}

}  // namespace
}  // namespace cwm
