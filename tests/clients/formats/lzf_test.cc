#include "clients/formats/lzf.h"

#include <gtest/gtest.h>

#include <random>
#include <string>

namespace cwm::formats {
namespace {

std::string Random(std::size_t size, int symbols, std::uint64_t seed) {
  std::mt19937_64 generator(seed);
  std::uniform_int_distribution<int> symbol(0, symbols - 1);
  std::string bytes(size, '\0');
  for (char& byte : bytes) byte = static_cast<char>(symbol(generator));
  return bytes;
}

TEST(Lzf, RoundTripsEverySizeAndDensity) {
  for (const int symbols : {1, 2, 16, 256}) {
    for (const std::size_t size :
         {0, 1, 2, 3, 4, 31, 32, 33, 264, 265, 1000, 8191, 8192, 8193, 50000}) {
      const std::string bytes = Random(size, symbols, size + symbols);
      const std::string packed = LzfCompress(bytes);
      EXPECT_LE(packed.size(), size + size / 32 + 1);
      const auto back = LzfDecompress(packed, size);
      ASSERT_TRUE(back.has_value()) << size << " bytes of " << symbols << " symbols";
      EXPECT_EQ(*back, bytes);
    }
  }
}

TEST(Lzf, PacksRunsToTheFormatsLimit) {
  const std::string zeros(26400, '\0');
  // One literal, then copies of 264 bytes at three bytes each.
  EXPECT_LE(LzfCompress(zeros).size(), 2 + 3 * (26400 / 264) + 4);
}

TEST(Lzf, DecodesACopyThatOverlapsItself) {
  // The literal "ab", then 6 bytes copied from 2 bytes back.
  const std::string packed = std::string("\x01") + "ab" + "\x80\x01";
  EXPECT_EQ(LzfDecompress(packed, 8), "abababab");
}

TEST(Lzf, RefusesWrongSizesAndCuts) {
  const std::string bytes = Random(3000, 4, 1);
  const std::string packed = LzfCompress(bytes);
  EXPECT_FALSE(LzfDecompress(packed, 2999).has_value());
  EXPECT_FALSE(LzfDecompress(packed, 3001).has_value());
  for (std::size_t size = 0; size < packed.size(); ++size) {
    EXPECT_FALSE(LzfDecompress(packed.substr(0, size), 3000).has_value());
  }
  EXPECT_FALSE(LzfDecompress(packed, std::size_t{1} << 60).has_value());
}

}  // namespace
}  // namespace cwm::formats
