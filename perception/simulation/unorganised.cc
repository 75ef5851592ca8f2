#include "perception/simulation/unorganised.h"

#include <cmath>
#include <numbers>
#include <utility>

#include "perception/simulation/random_draws.h"

namespace cwm::perception {
namespace {

// Streams of the seed, different from those of the sensor's errors.
constexpr std::uint64_t kOrderStream = 1001;
constexpr std::uint64_t kUpStream = 1002;

}  // namespace

SimulatedCloud Shuffled(const SimulatedCloud& scan, std::uint64_t seed) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < scan.cloud.points.size(); ++i) {
    if (scan.cloud.points[i].allFinite()) order.push_back(i);
  }
  RandomDraws draws(seed, kOrderStream);
  for (std::size_t left = order.size(); left > 1; --left) {  // Fisher and Yates
    const auto chosen = static_cast<std::size_t>(draws.Uniform() * static_cast<double>(left));
    std::swap(order[left - 1], order[chosen]);
  }
  SimulatedCloud shuffled;
  for (const std::size_t i : order) {
    shuffled.cloud.points.push_back(scan.cloud.points[i]);
    shuffled.object.push_back(scan.object[i]);
    shuffled.part.push_back(scan.part[i]);
  }
  shuffled.cloud.width = static_cast<int>(order.size());
  return shuffled;
}

Vector3 PerturbedUp(double error_rad, const Pose& X_WC, std::uint64_t seed) {
  RandomDraws draws(seed, kUpStream);
  const double heading_rad = draws.Uniform(0, 2 * std::numbers::pi);
  const double level = std::sin(error_rad);
  const Vector3 up_W(level * std::cos(heading_rad), level * std::sin(heading_rad),
                     std::cos(error_rad));
  return X_WC.linear().transpose() * up_W;
}

}  // namespace cwm::perception
