// Random numbers and poses that are the same on every machine.
#pragma once

#include <array>
#include <cstdint>
#include <random>

#include "clients/cpp/row_bytes.h"

namespace cwm::cli {

// An axis-aligned box in the world, in metres.
struct Region {
  std::array<double, 3> least, most;
};

// The region of the benchmark's own scene.
inline constexpr Region kBenchRegion{.least = {-0.5, -0.5, 0}, .most = {0.5, 0.5, 0.6}};

// The engine's numbers are defined by the standard; distributions differ from library to library.
class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}

  double Between(double least, double most);
  client::PointRow PointIn(const Region& region);
  // A pose with a uniformly distributed rotation.
  client::PoseRow PoseIn(const Region& region);

 private:
  std::mt19937_64 engine_;
};

}  // namespace cwm::cli
