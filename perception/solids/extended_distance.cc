#include "perception/solids/extended_distance.h"

#include <cmath>
#include <variant>

#include "collision/geometry/signed_distance.h"

namespace cwm::perception {
namespace {

struct ExtendedDistance {
  const Vector3& p;
  double operator()(const Box& box) const {
    return (p.cwiseAbs() - 0.5 * box.size_m).cwiseAbs().minCoeff();
  }
  double operator()(const Plate&) const { return std::abs(p.z()); }
  double operator()(const Cylinder& c) const { return std::abs(p.head<2>().norm() - c.radius_m); }
  double operator()(const Cone& c) const {
    const double slope = (c.radius_top_m - c.radius_bottom_m) / c.length_m;
    const double radius_m = 0.5 * (c.radius_bottom_m + c.radius_top_m) + slope * p.z();
    return std::abs(p.head<2>().norm() - radius_m) / std::sqrt(1 + slope * slope);
  }
  template <class Other>
  double operator()(const Other& shape) const {
    return std::abs(SignedDistance_m(shape, p));
  }
};

}  // namespace

double ExtendedDistance_m(const Shape& shape, const Vector3& p) {
  return std::visit(ExtendedDistance{p}, shape);
}

}  // namespace cwm::perception
