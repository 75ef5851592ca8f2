// Random numbers and poses that are the same on every machine.
#pragma once

#include <array>
#include <cstdint>
#include <random>

#include "clients/cpp/row_bytes.h"

namespace cwm::cli {

// An axis-aligned box in the world, in metres.
struct Region {
  std::array<double, 3> min, max;
};

// The region of the benchmark's own scene.
inline constexpr Region kBenchRegion{.min = {-0.5, -0.5, 0}, .max = {0.5, 0.5, 0.6}};

// The engine's numbers are defined by the standard; distributions differ from library to library.
class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}

  double Uniform(double min, double max);
  client::PointRow RandomPoint(const Region& region);
  // A pose with a uniformly distributed rotation.
  client::PoseRow RandomPose(const Region& region);

 private:
  std::mt19937_64 engine_;
};

}  // namespace cwm::cli
