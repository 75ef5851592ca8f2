#include "clients/cli/bench/bench_poses.h"

#include <cmath>
#include <numbers>

namespace cwm::cli {

double Random::Uniform(double min, double max) {
  // 53 random bits, the precision of a double.
  const double fraction = static_cast<double>(engine_() >> 11) * 0x1p-53;
  return min + fraction * (max - min);
}

client::PointRow Random::RandomPoint(const Region& region) {
  client::PointRow point;
  for (std::size_t k = 0; k < point.size(); ++k) {
    point[k] = Uniform(region.min[k], region.max[k]);
  }
  return point;
}

// cited: Shoemake, Uniform random rotations, Graphics Gems III, 1992.
client::PoseRow Random::RandomPose(const Region& region) {
  const client::PointRow at = RandomPoint(region);
  const double u = Uniform(0, 1);
  const double angle_a = Uniform(0, 2 * std::numbers::pi);
  const double angle_b = Uniform(0, 2 * std::numbers::pi);
  const double a = std::sqrt(1 - u), b = std::sqrt(u);
  return {at[0],
          at[1],
          at[2],
          a * std::sin(angle_a),
          a * std::cos(angle_a),
          b * std::sin(angle_b),
          b * std::cos(angle_b)};
}

}  // namespace cwm::cli
