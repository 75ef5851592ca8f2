// Pairs with a closed form, against the same geometry in extended precision: only rounding may be
// lost.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "collision/kernels/exact.h"
#include "tests/collision/kernels/long_double_oracle.h"
#include "tests/collision/kernels/random_pairs.h"

namespace cwm::collision {
namespace {

// derived: relative to the pair's extent, some thousand roundings of double.
constexpr double kRelative = 1e-12;

PairDistance Solve(const PosedPair& pair) {
  const auto a = PrepareExact(pair.a), b = PrepareExact(pair.b);
  return ExactDistance({*a, pair.X_FA}, {*b, pair.X_FB});
}

double ErrorShare(const PosedPair& pair) {
  const long double error = Solve(pair).distance_m - LongDoubleDistance_m(pair);
  return static_cast<double>(std::abs(error)) / ExtentOf(pair);
}

// Moves B along the normal so that the distance becomes about `distance_m`.
void MoveTo(PosedPair& pair, double distance_m) {
  const PairDistance answer = Solve(pair);
  pair.X_FB.translation() += (distance_m - answer.distance_m) * answer.normal;
}

using KindPair = std::pair<ShapeKind, ShapeKind>;
class ClosedForm : public ::testing::TestWithParam<KindPair> {};

TEST_P(ClosedForm, IsRightToTwelveDigitsFromAMillimetreToTenMetres) {
  RandomPairs random(41);
  double worst = 0;
  for (int k = 0; k < 2000; ++k) {
    worst = std::max(worst, ErrorShare(random.Pair(GetParam().first, GetParam().second)));
  }
  EXPECT_LE(worst, kRelative);
}

TEST_P(ClosedForm, IsRightToTwelveDigitsForKissesDownToOneRounding) {
  RandomPairs random(42);
  double worst = 0;
  for (int k = 0; k < 1000; ++k) {
    PosedPair pair = random.Pair(GetParam().first, GetParam().second);
    const double sign = random.Index(2) == 0 ? 1 : -1;
    MoveTo(pair, random.Index(10) == 0 ? 0 : sign * std::pow(10, random.Uniform(-16, -3)));
    worst = std::max(worst, ErrorShare(pair));
  }
  EXPECT_LE(worst, kRelative);
}

TEST_P(ClosedForm, IsRightToTwelveDigitsForHandSizedShapesInAndOutOfContact) {
  RandomPairs random(43);
  double worst = 0;
  for (int k = 0; k < 1000; ++k) {
    PosedPair pair = random.HandSizedPair(GetParam().first, GetParam().second);
    MoveTo(pair, random.Uniform(-0.02, 1));
    worst = std::max(worst, ErrorShare(pair));
  }
  EXPECT_LE(worst, kRelative);
}

// Axes that are nearly collinear, or cross with almost no gap, so that feet of perpendiculars lose
// digits.
TEST(ClosedFormInHardPoses, CapsulesWithNearlyParallelAxesKeepTwelveDigits) {
  RandomPairs random(44);
  double worst = 0;
  for (int k = 0; k < 20000; ++k) {
    PosedPair pair{Capsule{1e-3, random.Uniform(0.1, 2)}, Capsule{2e-3, random.Uniform(0.1, 2)}};
    pair.X_FA = random.AnyPose(3);
    const double angle_rad = std::pow(10, random.Uniform(-14, 0));
    const double gap_m = random.Index(8) == 0 ? 0 : std::pow(10, random.Uniform(-14, 0));
    Pose X_AB = Pose::Identity();
    X_AB.linear() = Eigen::AngleAxisd(angle_rad, Vector3::UnitX()).toRotationMatrix();
    X_AB.translation() = Vector3(gap_m, 0, random.Uniform(-0.5, 0.5));
    pair.X_FB = pair.X_FA * X_AB;
    worst = std::max(worst, ErrorShare(pair));
  }
  EXPECT_LE(worst, kRelative);
}

// Rounding destroys the direction away from an edge long before the distance to it.
TEST(ClosedFormInHardPoses, ASphereNextToAnEdgeKeepsTwelveDigits) {
  RandomPairs random(45);
  for (const Shape& shape :
       {Shape(Box{{0.2, 0.1, 0.3}}), Shape(Cylinder{0.1, 0.2}), Shape(Cone{0.1, 0.05, 0.2}),
        Shape(Plate{{{0, 0}, {0.2, 0}, {0.2, 0.1}, {0, 0.1}}, {}, 0.02})}) {
    double worst = 0;
    for (int k = 0; k < 2000; ++k) {
      const double off_m = std::pow(10, random.Uniform(-15, -8));
      const Vector3 edge = KindOf(shape) == ShapeKind::kBox ? Vector3(0.1, 0.05, 0.07)
                           : KindOf(shape) == ShapeKind::kPlate
                               ? Vector3(0.2, 0.03, 0)
                               : Vector3(KindOf(shape) == ShapeKind::kCone ? 0.05 : 0.1, 0, 0.1);
      PosedPair pair{shape, Sphere{1e-3}};
      pair.X_FB.translation() = edge + off_m * random.Direction();
      worst = std::max(worst, ErrorShare(pair));
    }
    EXPECT_LE(worst, kRelative) << NameOf(KindOf(shape));
  }
}

std::vector<KindPair> PairsWithAFormula() {
  std::vector<KindPair> pairs;
  for (int a = 0; a < kShapeKindCount; ++a) {
    for (int b = 0; b < kShapeKindCount; ++b) {
      if (HasLongDoubleOracle(ShapeKind(a), ShapeKind(b)))
        pairs.push_back({ShapeKind(a), ShapeKind(b)});
    }
  }
  return pairs;
}

INSTANTIATE_TEST_SUITE_P(AllPairs, ClosedForm, ::testing::ValuesIn(PairsWithAFormula()),
                         [](const ::testing::TestParamInfo<KindPair>& info) {
                           return std::string(NameOf(info.param.first)) + "_" +
                                  std::string(NameOf(info.param.second));
                         });

}  // namespace
}  // namespace cwm::collision
