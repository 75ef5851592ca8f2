#include "perception/solids/extended_solid.h"

#include <limits>

namespace cwm::perception {
namespace {

double SlopeOf(const Cone& cone) {
  return (cone.radius_top_m - cone.radius_bottom_m) / cone.length_m;
}

}  // namespace

std::optional<double> LengthAlong_m(const Shape& shape, Eigen::Index axis) {
  if (const auto* box = std::get_if<Box>(&shape)) return box->size_m[axis];
  if (axis != 2) return std::nullopt;
  if (const auto* cylinder = std::get_if<Cylinder>(&shape)) return cylinder->length_m;
  if (const auto* cone = std::get_if<Cone>(&shape)) return cone->length_m;
  return std::nullopt;
}

double MaxExtension_m(const Shape& shape, const SolidEnd& end) {
  if (!LengthAlong_m(shape, end.axis)) return 0;
  const auto* cone = std::get_if<Cone>(&shape);
  if (cone == nullptr) return std::numeric_limits<double>::infinity();
  const double shrinks = -end.sign * SlopeOf(*cone);
  const double radius_m = end.sign > 0 ? cone->radius_top_m : cone->radius_bottom_m;
  return shrinks > 0 ? radius_m / shrinks : std::numeric_limits<double>::infinity();
}

Placed<> Extended(Placed<> solid, const SolidEnd& end, double by_m) {
  solid.X_FS.translate(Vector3(0.5 * by_m * end.sign * Vector3::Unit(end.axis)));
  if (auto* box = std::get_if<Box>(&solid.shape)) {
    box->size_m[end.axis] += by_m;
  } else if (auto* cylinder = std::get_if<Cylinder>(&solid.shape)) {
    cylinder->length_m += by_m;
  } else if (auto* cone = std::get_if<Cone>(&solid.shape)) {
    (end.sign > 0 ? cone->radius_top_m : cone->radius_bottom_m) += end.sign * SlopeOf(*cone) * by_m;
    cone->length_m += by_m;
  }
  return solid;
}

}  // namespace cwm::perception
