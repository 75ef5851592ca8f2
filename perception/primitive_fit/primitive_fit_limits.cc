#include "perception/primitive_fit/primitive_fit_limits.h"

#include <cmath>
#include "perception/fit/model_selection.h"

namespace cwm::perception {
namespace {

// chosen: the least length of a lying solid, in radii; a shorter one falls on its end.
constexpr double kMinLying = 1.2;
// chosen: the least length of a leaning cylinder, in radii; a shorter one does not stay leaning.
constexpr double kMinLeaning = 2;
// chosen: the least radius of an upright cone's foot as a share of its height. With the mass in the
// middle such a cone tips at 11 degrees.
constexpr double kMinFoot = 0.1;

bool IsWithin(double radius_m, const ModelerOptions& options) {
  return radius_m >= options.min_radius_m && radius_m <= options.max_radius_m;
}

}  // namespace

bool IsValid(PrimitiveKind kind, const PrimitiveParameters& x, const ModelerOptions& options) {
  if (!x.allFinite() || std::abs(SlopeOf(kind, x)) > kMaxCupSlope) return false;
  if (IsLying(kind) && x(4) < kMinLying * x(3)) return false;
  if (kind == PrimitiveKind::kLeaningCylinder &&
      (std::abs(std::sin(x(3)) - 0.5) > 0.5 - kMinLean || x(5) < kMinLeaning * x(4))) {
    return false;
  }
  const Shape shape = Place(kind, x).shape;
  if (const auto* sphere = std::get_if<Sphere>(&shape)) return IsWithin(sphere->radius_m, options);
  if (const auto* cylinder = std::get_if<Cylinder>(&shape)) {
    return IsWithin(cylinder->radius_m, options) && cylinder->length_m >= options.min_radius_m;
  }
  if (const auto* cone = std::get_if<Cone>(&shape)) {
    if (!IsLying(kind) && cone->radius_bottom_m < kMinFoot * cone->length_m) return false;
    return IsWithin(cone->radius_bottom_m, options) && IsWithin(cone->radius_top_m, options) &&
           cone->length_m >= options.min_radius_m;
  }
  return std::get<Box>(shape).size_m.minCoeff() >= 2 * options.min_radius_m;
}

bool IsAtLimit(const PrimitiveFit& fit, const ModelerOptions& options) {
  // chosen: steps end at a limit or a little before it.
  constexpr double kLimitSlack = 1.02;
  if (const auto* box = std::get_if<Box>(&fit.solid.shape)) {
    return box->size_m.minCoeff() < kLimitSlack * 2 * options.min_radius_m;
  }
  return IsLying(fit.kind) && fit.parameters(4) < kLimitSlack * kMinLying * fit.parameters(3);
}

}  // namespace cwm::perception
