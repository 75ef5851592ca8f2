#include "perception/simulation/random_draws.h"

#include <cmath>
#include <numbers>

namespace cwm::perception {
namespace {

constexpr std::uint64_t kGoldenGamma = 0x9e3779b97f4a7c15ULL;  // 2^64 / golden ratio, odd

std::uint64_t Mix(std::uint64_t z) {
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  return z ^ (z >> 31);
}

}  // namespace

RandomDraws::RandomDraws(std::uint64_t seed, std::uint64_t stream)
    : state_(Mix(seed + kGoldenGamma) ^ Mix(~stream)) {}

std::uint64_t RandomDraws::Next() { return Mix(state_ += kGoldenGamma); }

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
