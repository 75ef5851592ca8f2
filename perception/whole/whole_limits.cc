#include "perception/whole/whole_limits.h"

#include <cmath>

namespace cwm::perception {
namespace {

constexpr double kSteepestSlope = 0.36;  // 20 degrees: wider cups are bowls
constexpr double kLeastLying = 1.2;      // radii of length: what is shorter falls on its end
// Sine of the elevation, and its distance from 1: nearer to level or upright a cylinder lies or stands.
constexpr double kLeastLean = 0.05;
constexpr double kLeastLeaning = 2;  // radii of length: what is shorter does not stay
// Of an upright cone's height, its foot's radius: with its mass in the middle it tips at 11 degrees.
constexpr double kLeastFoot = 0.1;

bool IsWithin(double radius_m, const ModelerOptions& options) {
  return radius_m >= options.min_radius_m && radius_m <= options.max_radius_m;
}

}  // namespace

bool IsValid(WholeKind kind, const WholeParameters& x, const ModelerOptions& options) {
  if (!x.allFinite() || std::abs(SlopeOf(kind, x)) > kSteepestSlope) return false;
  if (Lies(kind) && x(4) < kLeastLying * x(3)) return false;
  if (kind == WholeKind::kLeaningCylinder &&
      (std::abs(std::sin(x(3)) - 0.5) > 0.5 - kLeastLean || x(5) < kLeastLeaning * x(4))) {
    return false;
  }
  const Shape shape = Place(kind, x).shape;
  if (const auto* sphere = std::get_if<Sphere>(&shape)) return IsWithin(sphere->radius_m, options);
  if (const auto* cylinder = std::get_if<Cylinder>(&shape)) {
    return IsWithin(cylinder->radius_m, options) && cylinder->length_m >= options.min_radius_m;
  }
  if (const auto* cone = std::get_if<Cone>(&shape)) {
    if (!Lies(kind) && cone->radius_bottom_m < kLeastFoot * cone->length_m) return false;
    return IsWithin(cone->radius_bottom_m, options) && IsWithin(cone->radius_top_m, options) &&
           cone->length_m >= options.min_radius_m;
  }
  return std::get<Box>(shape).size_m.minCoeff() >= 2 * options.min_radius_m;
}

bool IsHeldBack(const WholeFit& fit, const ModelerOptions& options) {
  constexpr double kBarely = 1.02;  // steps end where the next one would be beyond
  if (const auto* box = std::get_if<Box>(&fit.solid.shape)) {
    return box->size_m.minCoeff() < kBarely * 2 * options.min_radius_m;
  }
  return Lies(fit.kind) && fit.parameters(4) < kBarely * kLeastLying * fit.parameters(3);
}

}  // namespace cwm::perception
