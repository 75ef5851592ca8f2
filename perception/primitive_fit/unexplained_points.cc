#include "perception/primitive_fit/unexplained_points.h"

#include <cmath>
#include <cstdint>
#include <vector>

#include "perception/cloud/tolerances.h"

namespace cwm::perception {

std::vector<char> MarkPointsOnSolids(const std::vector<Solid>& solids, const ModelPoints& points) {
  std::vector<char> on(points.size(), 0);
  for (const Solid& solid : solids) {
    const Pose X_SM = solid.X_MS.inverse(Eigen::Isometry);
    for (std::uint32_t i = 0; i < points.size(); ++i) {
      if (on[i]) continue;
      on[i] = std::abs(SignedDistance_m(solid, X_SM * points.p[i])) <= points.gate_m[i];
    }
  }
  return on;
}

bool IsFullyExplained(const std::vector<Solid>& solids, const FitContext& context) {
  const std::vector<char> on = MarkPointsOnSolids(solids, context.points);
  std::vector<std::uint32_t> rest;
  for (std::uint32_t i = 0; i < on.size(); ++i) {
    if (!on[i]) rest.push_back(i);
  }
  const auto all = static_cast<double>(on.size());
  if (static_cast<double>(rest.size()) > (1 - kNearlyAll) * all) return false;
  const std::size_t piece = context.connectivity.LargestComponent(rest).size();
  return static_cast<double>(piece) < kMinPiece * all;
}

}  // namespace cwm::perception
