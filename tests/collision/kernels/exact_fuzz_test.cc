#include <gtest/gtest.h>

#include <cmath>

#include "collision/kernels/exact.h"
#include "tests/collision/kernels/pair_fuzz.h"
#include "tests/collision/kernels/random_pairs.h"

namespace cwm::collision {
namespace {

TEST(ExactFuzz, FindsNothingWrongInPairsThatHurt) {
  const PairFuzz fuzz = FuzzPairs(7, 20'000);  // the benchmark uses 10 million
  EXPECT_EQ(fuzz.pairs, 20'000);
  EXPECT_EQ(fuzz.failures, 0) << fuzz.first;
}

// The overlap that remains after B has moved along the normal by the depth.
double LeftOver_m(const PosedPair& pair) {
  const auto a = PrepareExact(pair.a), b = PrepareExact(pair.b);
  const PairDistance answer = ExactDistance({*a, pair.X_FA}, {*b, pair.X_FB});
  return OverlapAlong(pair, answer.normal) + answer.distance_m;
}

constexpr int kPairs = 2'000;

// Positions on a long axis are rounded relative to its length, which matters for a small box.
TEST(ExactFuzz, PartsALongCapsuleFromASmallBoxThatItRunsThrough) {
  RandomPairs random(3);
  for (int k = 0; k < kPairs; ++k) {
    PosedPair pair{Box{{1e-3, 2.5e-3, 1.2e-3}}, Capsule{2.6e-3, 3.8}, random.AnyPose(10),
                   random.AnyPose(0)};
    const Vector3 through{random.Uniform(-5e-4, 5e-4), random.Uniform(-1e-3, 1e-3),
                          random.Uniform(-5e-4, 5e-4)};
    const Vector3 on_axis(0, 0, random.Uniform(-1.8, 1.8));
    pair.X_FB.translation() = pair.X_FA * through - pair.X_FB.linear() * on_axis;
    ASSERT_LE(LeftOver_m(pair), 1e-12) << k;
  }
}

// Such a small gap does not define a direction.
TEST(ExactFuzz, PartsASphereFromThePlateWhoseSideItsCentreNearlyTouches) {
  RandomPairs random(5);
  for (int k = 0; k < kPairs; ++k) {
    PosedPair pair{Plate{{{0, 0}, {7, 0}, {7, 9}, {0, 9}}, {}, 1e-3}, Sphere{3e-4},
                   random.AnyPose(10), Pose::Identity()};
    const double gap_m = std::pow(10, random.Uniform(-13, -6));
    pair.X_FB.translation() =
        pair.X_FA * Vector3{7 + gap_m, random.Uniform(0.1, 8.9), random.Uniform(-9e-4, -1e-4)};
    ASSERT_LE(LeftOver_m(pair), 1e-12) << k;
  }
}

TEST(ExactFuzz, PartsCapsulesOfWhichOneEndsNearlyOnTheOthersAxis) {
  RandomPairs random(9);
  for (int k = 0; k < kPairs; ++k) {
    PosedPair pair{Capsule{0.3, 11}, Capsule{0.8, 0.4}, random.AnyPose(1), random.AnyPose(0)};
    const double gap_m = std::pow(10, random.Uniform(-13, -9));
    const Vector3 end_W = pair.X_FA * Vector3(gap_m, 0, random.Uniform(-5, 5));
    pair.X_FB.translation() = end_W - pair.X_FB.linear() * Vector3(0, 0, 0.2);
    ASSERT_LE(LeftOver_m(pair), 1e-8) << k;
  }
}

}  // namespace
}  // namespace cwm::collision
