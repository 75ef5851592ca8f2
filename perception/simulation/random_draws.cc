#include "perception/simulation/random_draws.h"

#include <cmath>
#include <numbers>

#include "perception/cloud/split_mix.h"

namespace cwm::perception {

RandomDraws::RandomDraws(std::uint64_t seed, std::uint64_t stream)
    : state_(MixBits(seed + kGoldenGamma) ^ MixBits(~stream)) {}

std::uint64_t RandomDraws::Next() { return NextRandomBits(state_); }

double RandomDraws::Uniform() {
  return static_cast<double>(Next() >> 11) * 0x1.0p-53;  // the 53 bits that a double holds
}

double RandomDraws::Normal() {
  if (has_spare_) {
    has_spare_ = false;
    return spare_normal_;
  }
  const double radius = std::sqrt(-2 * std::log(1 - Uniform()));
  const double angle = 2 * std::numbers::pi * Uniform();
  spare_normal_ = radius * std::sin(angle);
  has_spare_ = true;
  return radius * std::cos(angle);
}

}  // namespace cwm::perception
