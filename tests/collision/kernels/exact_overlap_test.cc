// The overlap check gives the sign of the distance, for every pair and however near to touching.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <utility>

#include "collision/geometry/tessellate.h"
#include "collision/kernels/exact.h"
#include "tests/collision/kernels/random_pairs.h"

namespace cwm::collision {
namespace {

constexpr std::array kConvex = {ShapeKind::kSphere, ShapeKind::kBox, ShapeKind::kCylinder,
                                ShapeKind::kCone, ShapeKind::kCapsule};

// derived: the depth of round shapes is accurate to this share of the size, so a search may report
// a touching pair as overlapping, or the other way round.
constexpr double kIterative = 2e-9;

// The numbers of pairs for which the sign was checked.
struct Tally {
  int overlapping = 0;
  int apart = 0;
};

void ExpectTheSign(const Shape& a, const Pose& X_FA, const Shape& b, const Pose& X_FB,
                   double size_m, Tally& result) {
  const auto exact_a = PrepareExact(a), exact_b = PrepareExact(b);
  const PlacedExact placed_a{*exact_a, X_FA}, placed_b{*exact_b, X_FB};
  for (const auto& [first, second] :
       {std::pair(&placed_a, &placed_b), std::pair(&placed_b, &placed_a)}) {
    const bool overlap = ExactOverlap(*first, *second);
    // Holds however near the pair is: with limit 0 the distance search also ends once the distance
    // is proven positive.
    EXPECT_EQ(overlap, ExactDistance(*first, *second, 0).distance_m < 0)
        << size_m << ", kinds " << a.index() << " and " << b.index();
    const double distance_m = ExactDistance(*first, *second).distance_m;
    if (std::abs(distance_m) <= kIterative * size_m) continue;
    ++(distance_m < 0 ? result.overlapping : result.apart);
    EXPECT_EQ(overlap, distance_m < 0)
        << distance_m << " of " << size_m << ", kinds " << a.index() << " and " << b.index();
  }
}

TEST(ExactOverlap, IsTheSignOfTheDistanceOfConvexShapes) {
  constexpr std::array kOffsets = {1e-3, 1e-5, 1e-7, 1e-9, 1e-10, 1e-11};
  constexpr int kPairs = 400;
  RandomPairs random(31);
  for (const ShapeKind kind_a : kConvex) {
    for (const ShapeKind kind_b : kConvex) {
      Tally result;
      for (int k = 0; k < kPairs; ++k) {
        PosedPair pair = random.Pair(kind_a, kind_b);
        const double size_m = SizeOf(pair);
        ExpectTheSign(pair.a, pair.X_FA, pair.b, pair.X_FB, size_m, result);
        // The pair is also tested just before and just after touching.
        const auto a = PrepareExact(pair.a), b = PrepareExact(pair.b);
        const PairDistance answer = ExactDistance({*a, pair.X_FA}, {*b, pair.X_FB});
        const double offset_m = size_m * kOffsets[static_cast<std::size_t>(k) % kOffsets.size()];
        pair.X_FB.translation() -=
            (answer.distance_m + (k % 2 == 0 ? offset_m : -offset_m)) * answer.normal;
        ExpectTheSign(pair.a, pair.X_FA, pair.b, pair.X_FB, size_m, result);
      }
      EXPECT_GT(result.overlapping, kPairs / 4) << static_cast<int>(kind_a);
      EXPECT_GT(result.apart, kPairs / 4) << static_cast<int>(kind_a);
    }
  }
}

TEST(ExactOverlap, IsTheSignOfTheDistanceOfPlatesAndMeshes) {
  const Plate frame{{{-1, -1}, {1, -1}, {1, 1}, {-1, 1}},
                    {{{-0.5, -0.5}, {0.5, -0.5}, {0.5, 0.5}, {-0.5, 0.5}}},
                    0.1};
  Mesh closed{std::make_shared<const TriangleMesh>(Tessellate(Cylinder{0.5, 1}, 0.01)), true};
  Mesh open = closed;
  open.watertight = false;
  const std::array<Shape, 6> compound = {
      frame, closed, open, HalfSpace{}, Box{{0.3, 0.5, 0.7}}, Sphere{0.4}};
  RandomPairs random(32);
  for (std::size_t i = 0; i < compound.size(); ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      Tally result;
      for (int k = 0; k < 150; ++k) {
        ExpectTheSign(compound[i], random.AnyPose(1.2), compound[j], random.AnyPose(1.2), 1,
                      result);
      }
      EXPECT_GT(result.overlapping, 20) << i << ' ' << j;
      EXPECT_GT(result.apart, 3) << i << ' ' << j;
    }
  }
}

TEST(ExactOverlap, SeesASmallShapeDeepInsideOfALargeOne) {
  const auto vat =
      PrepareExact(Mesh{std::make_shared<const TriangleMesh>(Tessellate(Sphere{1}, 0.01)), true});
  const auto cube = PrepareExact(Box{{0.01, 0.01, 0.01}});
  const auto pebble = PrepareExact(
      Mesh{std::make_shared<const TriangleMesh>(Tessellate(Sphere{0.01}, 0.001)), true});
  const Pose I = Pose::Identity();
  EXPECT_TRUE(ExactOverlap({*vat, I}, {*cube, I}));
  EXPECT_TRUE(ExactOverlap({*pebble, I}, {*vat, I}));
  EXPECT_FALSE(ExactOverlap({*vat, I}, {*pebble, MakeTranslation(0, 0, 1.1)}));
}

}  // namespace
}  // namespace cwm::collision
