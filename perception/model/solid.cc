#include "perception/model/solid.h"

#include <algorithm>
#include <cmath>

#include "collision/geometry/aabb.h"

namespace cwm::perception {

double LowestHeight_m(const Solid& solid, const Ground& ground) {
  // Bounds in a frame whose z is up, its origin on the ground.
  Pose X_GM = Pose::Identity();
  X_GM.linear() = BasisFromZ(ground.up).transpose();
  X_GM.translation() = -(X_GM.linear() * ground.point);
  return TightBounds(solid.shape, X_GM * solid.X_MS).min().z();
}

double Quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0;
  const auto k = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + k, values.end());
  return values[static_cast<std::size_t>(k)];
}

Interval ExtentAlong(const Vector3& direction, const ModelPoints& points,
                     const std::vector<std::uint32_t>& listed) {
  constexpr double kRagged = 0.01;
  std::vector<double> values;
  values.reserve(listed.size());
  for (std::uint32_t i : listed) values.push_back(direction.dot(points.p[i]));
  const double low_m = Quantile(values, kRagged);
  return {low_m, Quantile(std::move(values), 1 - kRagged)};
}

}  // namespace cwm::perception
