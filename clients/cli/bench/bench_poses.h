// Random numbers and poses that are the same on every machine.
#pragma once

#include <array>
#include <cstdint>
#include <random>

#include "clients/cpp/row_bytes.h"

namespace cwm::cli {

// Axis-aligned, of the world; m.
struct Region {
  std::array<double, 3> least, most;
};

// Where the scene of a benchmark's own is.
inline constexpr Region kBenchRegion{.least = {-0.5, -0.5, 0}, .most = {0.5, 0.5, 0.6}};

// The engine's numbers are the standard's; its distributions differ from library to library.
class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}

  double Between(double least, double most);
  client::PointRow PointIn(const Region& region);
  // Of any direction alike.
  client::PoseRow PoseIn(const Region& region);

 private:
  std::mt19937_64 engine_;
};

}  // namespace cwm::cli
