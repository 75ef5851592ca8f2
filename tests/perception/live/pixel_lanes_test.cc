#include "perception/live/pixel_lanes.h"

#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "perception/live/frame_classes.h"

namespace cwm::perception {
namespace {

constexpr float kInfinite_m = std::numeric_limits<float>::infinity();
constexpr std::size_t kCount = 1'003;  // no multiple of any register

std::vector<float> Draw(std::mt19937& random, float least, float greatest, std::size_t count) {
  std::uniform_real_distribution<float> number(least, greatest);
  std::vector<float> drawn(count);
  for (float& each : drawn) each = number(random);
  return drawn;
}

TEST(CompareWithGates, TellsWhatIsWithinAndWhatIsMissing) {
  std::mt19937 random(1);
  std::vector<float> depth_m = Draw(random, 0.5F, 2, kCount);
  std::vector<float> low_m = Draw(random, 0.5F, 2, kCount);
  std::vector<float> high_m = low_m;
  for (std::size_t i = 0; i < kCount; ++i) {
    high_m[i] += 0.5F;
    if (i % 5 == 0) depth_m[i] = 0;
    if (i % 7 == 0) depth_m[i] = low_m[i];
    if (i % 11 == 0) depth_m[i] = high_m[i];
    if (i % 13 == 0) low_m[i] = high_m[i] = kInfinite_m;  // no gate
  }
  std::vector<std::uint8_t> classes(kCount, 0xFF);
  CompareWithGates(depth_m.data(), low_m.data(), high_m.data(), kCount, classes.data());
  int within = 0;
  for (std::size_t i = 0; i < kCount; ++i) {
    const bool is_within = depth_m[i] >= low_m[i] && depth_m[i] <= high_m[i];
    const PixelClass otherwise = depth_m[i] == 0 ? PixelClass::kMissing : PixelClass(0);
    EXPECT_EQ(PixelClass(classes[i]), is_within ? PixelClass::kConsistent : otherwise) << i;
    within += static_cast<int>(is_within);
  }
  EXPECT_GT(within, 100);
  EXPECT_LT(within, 900);
}

// The formulas of an exponentially weighted mean and variance, pixel by pixel.
TEST(LearnDepths, FollowsTheDepthsWithinTheGates) {
  constexpr std::size_t kPixels = 64;
  constexpr LearningGains kGains = {.mean = 0.125F, .spread = 0.03125F, .validity = 0.0625F};
  std::mt19937 random(2);
  const std::vector<float> depth_m = Draw(random, 0.99F, 1.01F, kPixels);
  std::vector<float> mean_m(kPixels, 1);
  std::vector<float> variance_m2(kPixels, 1e-5F);
  std::vector<float> validity = Draw(random, 0, 1, kPixels);
  std::vector<float> low_m(kPixels, 0.995F);
  std::vector<float> high_m(kPixels, 1.005F);
  const std::vector<float> validity_before = validity;
  LearnDepths(depth_m.data(),
              {.mean_m = mean_m.data(),
               .variance_m2 = variance_m2.data(),
               .validity = validity.data(),
               .low_m = low_m.data(),
               .high_m = high_m.data()},
              kPixels, kGains);
  for (std::size_t i = 0; i < kPixels; ++i) {
    const bool is_return = depth_m[i] >= low_m[i] && depth_m[i] <= high_m[i];
    const float deviation = is_return ? depth_m[i] - 1 : 0;
    EXPECT_FLOAT_EQ(mean_m[i], 1 + 0.125F * deviation) << i;
    const float variance =
        is_return ? 1e-5F + 0.03125F * (0.875F * deviation * deviation - 1e-5F) : 1e-5F;
    EXPECT_FLOAT_EQ(variance_m2[i], variance) << i;
    const float seen = is_return ? 1 : 0;
    EXPECT_FLOAT_EQ(validity[i], validity_before[i] + (seen - validity_before[i]) * 0.0625F) << i;
  }
}

TEST(SetGates, AreWideByTheVarianceOfADepthAndOfTheMean) {
  std::vector<float> mean_m(kPixelGroup, 2);
  std::vector<float> variance_m2(kPixelGroup, 4e-6F);
  const std::vector<float> prior_m2(kPixelGroup, 9e-6F);
  std::vector<float> low_m(kPixelGroup, 0);
  std::vector<float> high_m(kPixelGroup, 0);
  mean_m[3] = 1e-4F;  // its gate must not hold 0
  SetGates({.mean_m = mean_m.data(),
            .variance_m2 = variance_m2.data(),
            .low_m = low_m.data(),
            .high_m = high_m.data(),
            .prior_m2 = prior_m2.data()},
           kPixelGroup,
           {.mean = 0.125F, .prior_share = 0.2F, .gate_sigma = 5, .least_low_m = 1e-6F});
  // 0.8 * 4e-6 + 0.2 * 9e-6 = 5e-6, times 1.125 for the error of the mean: 2.3717 mm.
  constexpr float kGate_m = 5 * 2.3717e-3F;
  EXPECT_NEAR(low_m[0], 2 - kGate_m, 1e-6);
  EXPECT_NEAR(high_m[0], 2 + kGate_m, 1e-6);
  EXPECT_EQ(low_m[3], 1e-6F);
}

}  // namespace
}  // namespace cwm::perception
