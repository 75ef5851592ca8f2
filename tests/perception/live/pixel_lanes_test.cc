#include "perception/live/pixel_lanes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <utility>
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

TEST(FindDeviations, SetsABitForEachPixelThatIsNotConsistent) {
  std::mt19937 random(3);
  std::vector<std::uint8_t> classes(kCount, 1);
  std::vector<BodyId> bodies(kCount, 7);
  for (std::size_t i = 0; i < kCount; ++i) {
    if (random() % 6 == 0) classes[i] = static_cast<std::uint8_t>(random() % kPixelClasses);
    if (i / kPixelsPerWord == 3) bodies[i] = static_cast<BodyId>(i % 2);
  }
  bodies[2 * kPixelsPerWord - 1] = 8;  // the last pixel of a word
  std::vector<DeviatingPixels> words(kCount / kPixelsPerWord + 1);
  FindDeviations(classes.data(), bodies.data(), kCount, words.data());
  std::vector<int> missing_count(words.size(), 0);
  for (std::size_t i = 0; i < words.size() * kPixelsPerWord; ++i) {
    const PixelClass pixel = i < kCount ? PixelClass(classes[i]) : PixelClass::kConsistent;
    const DeviatingPixels& word = words[i / kPixelsPerWord];
    const bool is_missing = pixel == PixelClass::kMissing;
    EXPECT_EQ((word.missing >> i % kPixelsPerWord & 1) != 0, is_missing) << i;
    EXPECT_EQ((word.others >> i % kPixelsPerWord & 1) != 0,
              !is_missing && pixel != PixelClass::kConsistent)
        << i;
    missing_count[i / kPixelsPerWord] += static_cast<int>(is_missing);
  }
  for (std::size_t k = 0; k < words.size(); ++k) {
    EXPECT_EQ(words[k].missing_count, missing_count[k]) << k;
    // The last word is not whole.
    EXPECT_EQ(words[k].is_one_body, k != 1 && k != 3 && k + 1 != words.size()) << k;
  }
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

// A row of pixels with two rows above and two below, and two columns on either side; some of their
// depths are not known.
class Neighbourhood : public ::testing::Test {
 protected:
  static constexpr int kPixels = 48;
  static constexpr int kBeside = static_cast<int>(kBeside_px);

  Neighbourhood() {
    std::mt19937 random(4);
    for (std::vector<float>& row : rows_) {
      row = Draw(random, 1, 1.1F, kPixels + 2 * kBeside_px);
      for (float& depth_m : row) {
        if (random() % 4 == 0) depth_m = kInfinite_m;
      }
    }
    for (std::size_t u = 0; u < kPixels; ++u) {
      rows_[kBeside_px][u + kBeside_px] = 1.05F + 1e-3F * static_cast<float>(u);
    }
  }

  DepthsAround around() const {
    DepthsAround pointers = {};
    for (std::size_t k = 0; k < pointers.size(); ++k) pointers[k] = rows_[k].data() + kBeside_px;
    return pointers;
  }
  // The depth beside a pixel; that of the pixel itself where it is not known.
  float At(int u, int du, int dv) const {
    const int row = kBeside + dv;
    const int column = kBeside + u + du;
    const float depth_m = rows_[static_cast<std::size_t>(row)][static_cast<std::size_t>(column)];
    return depth_m == kInfinite_m ? At(u, 0, 0) : depth_m;
  }

  std::array<std::vector<float>, 2 * kBeside_px + 1> rows_;
};

TEST_F(Neighbourhood, HasItsGreatestBend) {
  std::vector<float> bends_m(kPixels, -1);
  FindBends(around(), kPixels, bends_m.data());
  for (int u = 0; u < kPixels; ++u) {
    float greatest_m = 0;
    for (int step = 1; step <= kBeside; ++step) {
      for (const auto& [du, dv] : {std::pair(step, 0), {0, step}, {step, step}, {step, -step}}) {
        const float bend_m = std::abs(At(u, du, dv) + At(u, -du, -dv) - 2 * At(u, 0, 0));
        greatest_m = std::max(greatest_m, bend_m);
      }
    }
    EXPECT_EQ(bends_m[static_cast<std::size_t>(u)], greatest_m) << u;
  }
}

TEST_F(Neighbourhood, HasALeastAndAGreatestDepth) {
  std::vector<float> least_m(kPixels, -1);
  std::vector<float> greatest_m(kPixels, -1);
  FindExtremes(around(), kPixels, least_m.data(), greatest_m.data());
  for (int u = 0; u < kPixels; ++u) {
    float least = kInfinite_m;
    float greatest = 0;
    for (int dv = -kBeside; dv <= kBeside; ++dv) {
      for (int du = -kBeside; du <= kBeside; ++du) {
        least = std::min(least, At(u, du, dv));
        greatest = std::max(greatest, At(u, du, dv));
      }
    }
    EXPECT_EQ(least_m[static_cast<std::size_t>(u)], least) << u;
    EXPECT_EQ(greatest_m[static_cast<std::size_t>(u)], greatest) << u;
  }
}

TEST(SetGatesAbout, HoldsBothSidesOfAnEdgeAndLeavesOtherPixels) {
  constexpr std::size_t kPixels = 16;
  constexpr int kMature = 24;
  std::vector<float> mean_m(kPixels, 2);
  std::vector<float> variance_m2(kPixels, 4e-6F);
  const std::vector<float> prior_m2(kPixels, 9e-6F);
  std::vector<float> low_m(kPixels, 7);
  std::vector<float> high_m(kPixels, 8);
  std::vector<std::uint8_t> is_set(kPixels, 1), frames(kPixels, kMature), is_edge(kPixels, 0);
  is_set[2] = 0;
  is_edge[4] = 1;
  frames[9] = 3;
  const std::vector<float> least_m(kPixels, 1.9F), greatest_m(kPixels, 2.2F);
  SetGatesAbout({.mean_m = mean_m.data(),
                 .variance_m2 = variance_m2.data(),
                 .low_m = low_m.data(),
                 .high_m = high_m.data(),
                 .prior_m2 = prior_m2.data()},
                {.is_set = is_set.data(),
                 .frames = frames.data(),
                 .is_edge = is_edge.data(),
                 .least_m = least_m.data(),
                 .greatest_m = greatest_m.data()},
                kMature, kPixels,
                {.mean = 0.125F, .prior_share = 0.2F, .gate_sigma = 5, .least_low_m = 1e-6F});
  // 0.8 * 4e-6 + 0.2 * 9e-6 = 5e-6, times 1.125 for the error of the mean, or times 4 / 3 for that
  // of a mean of three frames.
  constexpr float kGate_m = 5 * 2.3717e-3F;
  constexpr float kYoungGate_m = 5 * 2.5820e-3F;
  for (std::size_t i = 0; i < kPixels; ++i) {
    const float gate_m = i == 9 ? kYoungGate_m : kGate_m;
    EXPECT_NEAR(low_m[i], i == 2 ? 7 : (i == 4 ? 1.9F : 2) - gate_m, 1e-6) << i;
    EXPECT_NEAR(high_m[i], i == 2 ? 8 : (i == 4 ? 2.2F : 2) + gate_m, 1e-6) << i;
  }
}

}  // namespace
}  // namespace cwm::perception
