// The test of a body's shift against noise with a known spread.
#include <gtest/gtest.h>

#include "perception/live/shift_test.h"
#include "perception/simulation/random_draws.h"

namespace cwm::perception {
namespace {

constexpr double kSigma_m = 0.0006;

Vector6 Noise(RandomDraws& draws, double sigma_m) {
  Vector6 noise_m;
  for (int i = 0; i < 6; ++i) noise_m[i] = sigma_m * draws.Normal();
  return noise_m;
}

// Frames until a shift along the first component is told; -1: not within 60 frames.
int DelayOf(double shift_m, std::uint64_t seed) {
  RandomDraws draws(seed, 0);
  ShiftTest test;
  for (int frame = 0; frame < 60; ++frame) {
    if (test.Add(Noise(draws, kSigma_m), Vector6::Constant(kSigma_m))) return -1;
  }
  for (int frame = 1; frame <= 60; ++frame) {
    Vector6 measured_m = Noise(draws, kSigma_m);
    measured_m[0] += shift_m;
    if (!test.Add(measured_m, Vector6::Constant(kSigma_m))) continue;
    EXPECT_NEAR(test.Shift_m()[0], shift_m, 0.9 * shift_m) << "seed " << seed;
    return frame;
  }
  return -1;
}

TEST(ShiftTest, TellsNoShiftInAMillionComponentsOfNoise) {
  RandomDraws draws(7, 0);
  int alarms = 0;
  for (int body = 0; body < 17; ++body) {
    ShiftTest test;
    for (int frame = 0; frame < 10'000; ++frame) {
      if (test.Add(Noise(draws, kSigma_m), Vector6::Constant(kSigma_m))) ++alarms, test.Reset();
    }
  }
  EXPECT_LE(alarms, 2);
}

// A recording of two frames that is played again and again shows less noise than there is; the
// spread that it seems to have would tell a shift in every second run.
TEST(ShiftTest, TakesTheNextFramesAfterTwoThatWereRepeatedForNoShift) {
  int alarms = 0;
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    RandomDraws draws(seed, 1);
    const Vector6 repeated_m[] = {Noise(draws, 0.5 * kSigma_m), Noise(draws, 0.5 * kSigma_m)};
    ShiftTest test;
    for (int frame = 0; frame < 300; ++frame) {
      test.Add(repeated_m[frame % 2], Vector6::Constant(kSigma_m));
    }
    for (int frame = 0; frame < 6; ++frame) {
      alarms += test.Add(Noise(draws, 0.5 * kSigma_m), Vector6::Constant(kSigma_m)) ? 1 : 0;
    }
  }
  EXPECT_LE(alarms, 8);
}

// The assumed spread may be wrong by a factor of two either way.
TEST(ShiftTest, LearnsTheSpread) {
  for (const double factor : {0.5, 2.0}) {
    RandomDraws draws(9, 0);
    ShiftTest test;
    int alarms = 0;
    for (int frame = 0; frame < 20'000; ++frame) {
      if (test.Add(Noise(draws, kSigma_m), Vector6::Constant(factor * kSigma_m))) {
        ++alarms;
        test.Reset();
      }
    }
    EXPECT_LE(alarms, factor < 1 ? 3 : 1) << factor;
  }
}

TEST(ShiftTest, TellsAShiftOfThreeDeviationsWithinAThirdOfASecond) {
  int late = 0;
  double sum = 0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    const int delay = DelayOf(3 * kSigma_m, seed);
    ASSERT_GT(delay, 0) << "seed " << seed;
    sum += delay;
    if (delay > 10) ++late;
  }
  EXPECT_LE(late, 4);
  EXPECT_LT(sum / 200, 6);
}

TEST(ShiftTest, FollowsSlowDrift) {
  RandomDraws draws(11, 0);
  ShiftTest test;
  for (int frame = 0; frame < 3'000; ++frame) {
    Vector6 measured_m = Noise(draws, kSigma_m);
    measured_m[2] += 1e-6 * frame;  // 3 mm within 100 seconds
    EXPECT_FALSE(test.Add(measured_m, Vector6::Constant(kSigma_m))) << "frame " << frame;
  }
}

}  // namespace
}  // namespace cwm::perception
