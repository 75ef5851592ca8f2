// Morton keys: neighbours in space are mostly neighbours in their order.
#pragma once

#include <cstdint>
#include <limits>

namespace cwm::perception {

// derived: three axes in one key.
inline constexpr int kMortonBitsPerAxis = std::numeric_limits<std::uint64_t>::digits / 3;

// Spreads the low 21 bits so that two zero bits follow each.
inline std::uint64_t SpreadBits(std::uint64_t v) {
  v &= 0x1fffff;
  v = (v | v << 32) & 0x1f00000000ffffULL;
  v = (v | v << 16) & 0x1f0000ff0000ffULL;
  v = (v | v << 8) & 0x100f00f00f00f00fULL;
  v = (v | v << 4) & 0x10c30c30c30c30c3ULL;
  return (v | v << 2) & 0x1249249249249249ULL;
}

// Its inverse: every third bit, from the lowest.
inline std::uint32_t GatherBits(std::uint64_t v) {
  v &= 0x1249249249249249ULL;
  v = (v | v >> 2) & 0x10c30c30c30c30c3ULL;
  v = (v | v >> 4) & 0x100f00f00f00f00fULL;
  v = (v | v >> 8) & 0x1f0000ff0000ffULL;
  v = (v | v >> 16) & 0x1f00000000ffffULL;
  return static_cast<std::uint32_t>((v | v >> 32) & 0x1fffff);
}

// The key of cell coordinates below 2^kMortonBitsPerAxis: their bits interleaved, x lowest.
// Coordinates of n bits make a key of 3 n bits.
inline std::uint64_t MortonKey(std::uint32_t x, std::uint32_t y, std::uint32_t z) {
  return SpreadBits(x) | SpreadBits(y) << 1 | SpreadBits(z) << 2;
}

}  // namespace cwm::perception
