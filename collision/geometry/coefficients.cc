#include "collision/geometry/coefficients.h"

#include <cmath>

namespace cwm {
namespace {

struct CoefficientsOf {
  const Pose& X_FS;

  Vector3 centre() const { return X_FS.translation(); }
  Vector3 axis() const { return X_FS.linear().col(2); }

  std::vector<double> operator()(const Sphere& s) const {
    const Vector3 c = centre();
    return {c.x(), c.y(), c.z(), s.radius_m};
  }
  std::vector<double> operator()(const Cylinder& s) const {
    const Vector3 q = centre(), a = axis();
    return {q.x(), q.y(), q.z(), a.x(), a.y(), a.z(), s.radius_m};
  }
  std::vector<double> operator()(const Cone& s) const {
    const double growth_m = s.radius_top_m - s.radius_bottom_m;
    if (growth_m == 0) return {};
    // The radius, linear in z, vanishes at the apex.
    const double z_apex = -0.5 * s.length_m - s.radius_bottom_m * s.length_m / growth_m;
    const Vector3 apex = centre() + z_apex * axis();
    const Vector3 a = std::copysign(1.0, growth_m) * axis();
    const double half_angle_rad = std::atan2(std::abs(growth_m), s.length_m);
    return {apex.x(), apex.y(), apex.z(), a.x(), a.y(), a.z(), half_angle_rad};
  }
  std::vector<double> operator()(const HalfSpace&) const { return TopPlane(); }
  std::vector<double> operator()(const Plate&) const { return TopPlane(); }
  std::vector<double> operator()(const Box&) const { return {}; }
  std::vector<double> operator()(const Capsule&) const { return {}; }
  std::vector<double> operator()(const Convex&) const { return {}; }
  std::vector<double> operator()(const Mesh&) const { return {}; }

  std::vector<double> TopPlane() const {
    const Vector3 n = axis();
    return {n.x(), n.y(), n.z(), -n.dot(centre())};
  }
};

}  // namespace

std::vector<double> Coefficients(const Shape& shape, const Pose& X_FS) {
  return std::visit(CoefficientsOf{X_FS}, shape);
}

}  // namespace cwm
