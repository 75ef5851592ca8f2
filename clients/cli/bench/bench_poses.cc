#include "clients/cli/bench/bench_poses.h"

#include <cmath>
#include <numbers>

namespace cwm::cli {

double Random::Between(double least, double most) {
  // 53 random bits, the precision of a double.
  const double share = static_cast<double>(engine_() >> 11) * 0x1p-53;
  return least + share * (most - least);
}

client::PointRow Random::PointIn(const Region& region) {
  client::PointRow point;
  for (std::size_t k = 0; k < point.size(); ++k) {
    point[k] = Between(region.least[k], region.most[k]);
  }
  return point;
}

// cited: Shoemake, Uniform random rotations, Graphics Gems III, 1992.
client::PoseRow Random::PoseIn(const Region& region) {
  const client::PointRow at = PointIn(region);
  const double share = Between(0, 1);
  const double one = Between(0, 2 * std::numbers::pi);
  const double other = Between(0, 2 * std::numbers::pi);
  const double a = std::sqrt(1 - share), b = std::sqrt(share);
  return {at[0],
          at[1],
          at[2],
          a * std::sin(one),
          a * std::cos(one),
          b * std::sin(other),
          b * std::cos(other)};
}

}  // namespace cwm::cli
