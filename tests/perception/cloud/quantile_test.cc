// The small functions that every stage uses: quantiles, Morton keys, random bits.
#include "perception/cloud/quantile.h"

#include <gtest/gtest.h>

#include <vector>

#include "perception/cloud/morton.h"
#include "perception/cloud/split_mix.h"

namespace cwm::perception {
namespace {

TEST(Quantile, IsTheValueOfItsRankInAnyOrder) {
  EXPECT_EQ(Quantile(std::vector<double>{5, 1, 4, 2, 3}, 0), 1);
  EXPECT_EQ(Quantile(std::vector<double>{5, 1, 4, 2, 3}, 0.5), 3);
  EXPECT_EQ(Quantile(std::vector<double>{5, 1, 4, 2, 3}, 0.74), 3);  // rank 2.96, rounded down
  EXPECT_EQ(Quantile(std::vector<double>{5, 1, 4, 2, 3}, 1), 5);
  EXPECT_EQ(Quantile(std::vector<double>{}, 0.5), 0);
}

TEST(Median, IsTheUpperOneOfTwo) {
  EXPECT_EQ(Median(std::vector<float>{3, 1, 2}), 2);
  EXPECT_EQ(Median(std::vector<float>{4, 1, 3, 2}), 3);
  EXPECT_EQ(Median(std::vector<float>{}), 0);
}

// The key built bit by bit, as its definition says.
std::uint64_t Interleaved(std::uint32_t x, std::uint32_t y, std::uint32_t z) {
  std::uint64_t key = 0;
  for (int bit = 0; bit < kMortonBitsPerAxis; ++bit) {
    key |= static_cast<std::uint64_t>(x >> bit & 1) << (3 * bit);
    key |= static_cast<std::uint64_t>(y >> bit & 1) << (3 * bit + 1);
    key |= static_cast<std::uint64_t>(z >> bit & 1) << (3 * bit + 2);
  }
  return key;
}

TEST(MortonKey, InterleavesTheBitsOfTheAxes) {
  std::uint64_t state = 3;
  for (int trial = 0; trial < 1000; ++trial) {
    const std::uint64_t bits = NextRandomBits(state);
    const auto x = static_cast<std::uint32_t>(bits & 0x1fffff);
    const auto y = static_cast<std::uint32_t>(bits >> 21 & 0x1fffff);
    const auto z = static_cast<std::uint32_t>(bits >> 42 & 0x1fffff);
    EXPECT_EQ(MortonKey(x, y, z), Interleaved(x, y, z));
  }
  EXPECT_EQ(MortonKey(1023, 1023, 1023), (1ULL << 30) - 1);  // 10 bits make a key of 30
}

TEST(NextRandomBits, AreThoseOfThePublishedGenerator) {
  // The first three values for seed 1234567 from the authors' reference implementation.
  std::uint64_t state = 1234567;
  EXPECT_EQ(NextRandomBits(state), 6457827717110365317ULL);
  EXPECT_EQ(NextRandomBits(state), 3203168211198807973ULL);
  EXPECT_EQ(NextRandomBits(state), 9817491932198370423ULL);
}

}  // namespace
}  // namespace cwm::perception
