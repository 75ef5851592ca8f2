#include "collision/geometry/surface_sigma.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <vector>

namespace cwm {
namespace {

struct SigmaOf {
  const std::vector<double>& s;  // standard deviations of the coefficients
  const Vector3& axis;           // axis of the shape, in the frame of the coefficients

  // Empty for shapes without a formula, and if the number of deviations does not match the shape.
  std::optional<double> operator()(const Sphere&) const {
    return Has(4) ? std::optional(Norm(0) + s[3]) : std::nullopt;
  }
  std::optional<double> operator()(const Cylinder& shape) const {
    if (!Has(7)) return std::nullopt;
    return Norm(0) + std::hypot(0.5 * shape.length_m, shape.radius_m) * Norm(3) + s[6];
  }
  std::optional<double> operator()(const Cone& shape) const {
    const double growth_m = std::abs(shape.radius_top_m - shape.radius_bottom_m);
    if (!Has(7) || growth_m == 0) return std::nullopt;
    // Similar triangles: slant of the whole cone / its base radius = flank / growth of the radius.
    const double max_radius_m = std::max(shape.radius_top_m, shape.radius_bottom_m);
    const double flank_m = std::hypot(growth_m, shape.length_m);
    const double slant_m = flank_m * max_radius_m / growth_m;
    return std::min(Norm(0), OfApex(growth_m / flank_m)) + slant_m * (Norm(3) + s[6]);
  }
  std::optional<double> operator()(const Plate& shape) const {
    if (!Has(4) || shape.outline.empty()) return std::nullopt;
    Vector2 min = shape.outline.front(), max = min;
    for (const Vector2& p : shape.outline) {
      min = min.cwiseMin(p);
      max = max.cwiseMax(p);
    }
    return s[3] + (max - min).norm() * Norm(0);
  }
  std::optional<double> operator()(const Box&) const {
    return Has(3) ? std::optional(Norm(0)) : std::nullopt;
  }
  std::optional<double> operator()(const Capsule&) const { return std::nullopt; }
  std::optional<double> operator()(const HalfSpace&) const { return std::nullopt; }
  std::optional<double> operator()(const Convex&) const { return std::nullopt; }
  std::optional<double> operator()(const Mesh&) const { return std::nullopt; }

  // The displacement of the flank by a displacement of the apex: all of it across the axis, and the
  // sine of the half angle of it along the axis. The coordinates' shares are added, since they may
  // be correlated.
  double OfApex(double sine) const {
    double sum_m = 0;
    for (int k = 0; k < 3; ++k) {
      const double along = std::abs(axis[k]), across = std::sqrt(std::max(0.0, 1 - along * along));
      sum_m += s[static_cast<std::size_t>(k)] * (sine * along + across);
    }
    return sum_m;
  }
  bool Has(std::size_t count) const { return s.size() == count; }
  double Norm(std::size_t first) const { return std::hypot(s[first], s[first + 1], s[first + 2]); }
};

}  // namespace

double SurfaceSigma_m(const ShapePart& part) {
  if (!part.fit.has_value()) return 0;
  const Vector3 axis = part.X_OS.linear().col(2);
  return std::visit(SigmaOf{part.fit->parameter_sigma, axis}, part.shape).value_or(part.fit->rms_m);
}

}  // namespace cwm
