// Random bits that depend on the seed alone: SplitMix64 (Steele, Lea and Flood, "Fast Splittable
// Pseudorandom Number Generators", 2014). One state per stream; every state is a good one.
#pragma once

#include <cstdint>

namespace cwm::perception {

// cited: 2^64 over the golden ratio, odd.
inline constexpr std::uint64_t kGoldenGamma = 0x9e3779b97f4a7c15ULL;

// A bijection of 64 bits in which every bit of the input changes about half of the output's.
inline std::uint64_t MixBits(std::uint64_t z) {
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  return z ^ (z >> 31);
}

inline std::uint64_t NextRandomBits(std::uint64_t& state) { return MixBits(state += kGoldenGamma); }

}  // namespace cwm::perception
