// Random indices that depend on the seed alone; the standard library's distributions differ between
// implementations.
#pragma once

#include <cstddef>
#include <cstdint>
#include <random>

namespace cwm::perception {

// Uniform in [0, count), by multiplication (Lemire 2019) without its rejection step: the bias is
// below count / 2^32. `count` is at least 1 and less than 2^32.
inline std::size_t RandomIndex(std::mt19937_64& random, std::size_t count) {
  return static_cast<std::size_t>(((random() >> 32) * static_cast<std::uint64_t>(count)) >> 32);
}

}  // namespace cwm::perception
