// Random numbers that only depend on the seed; those of the standard library also depend on its
// implementation.
#pragma once

#include <cstdint>

namespace cwm::perception {

// Draws from SplitMix64 (split_mix.h). Different streams of one seed are independent.
class RandomDraws {
 public:
  RandomDraws(std::uint64_t seed, std::uint64_t stream);

  double Uniform();  // [0, 1)
  double Uniform(double low, double high) { return low + (high - low) * Uniform(); }
  int Below(int count) { return static_cast<int>(count * Uniform()); }  // 0 to count - 1
  double Normal();  // mean 0, standard deviation 1 (Box and Muller 1958)

 private:
  std::uint64_t Next();

  std::uint64_t state_;
  double spare_normal_ = 0;
  bool has_spare_ = false;
};

}  // namespace cwm::perception
