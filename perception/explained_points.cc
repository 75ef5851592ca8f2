#include "perception/explained_points.h"

#include <cmath>

namespace cwm::perception {
namespace {

bool Near(const ShapePart& part, const Vector3& point, double tolerance_m) {
  const Vector3 local = part.X_OS.inverse(Eigen::Isometry) * point;
  return std::abs(SignedDistance_m(part, local)) <= tolerance_m;
}

}  // namespace

bool IsNearAnyShape(const std::vector<ShapePart>& shapes, std::int32_t likely, const Vector3& point,
                    double tolerance_m) {
  const bool has_likely = likely >= 0 && static_cast<std::size_t>(likely) < shapes.size();
  if (has_likely && Near(shapes[static_cast<std::size_t>(likely)], point, tolerance_m)) return true;
  for (std::size_t s = 0; s < shapes.size(); ++s) {
    if (has_likely && s == static_cast<std::size_t>(likely)) continue;
    if (Near(shapes[s], point, tolerance_m)) return true;
  }
  return false;
}

}  // namespace cwm::perception
