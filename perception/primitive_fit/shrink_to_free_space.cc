#include "perception/primitive_fit/shrink_to_free_space.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <variant>
#include <vector>

#include "collision/geometry/coefficients.h"
#include "perception/cloud/tolerances.h"
#include "perception/solids/free_space.h"

namespace cwm::perception {
namespace {

// chosen: as a share of the radius, twice a focal length's relative error of 0.025. Drivers assume
// 525 pixels for every Kinect; one of 544 pixels is off by more, but with 0.07 a tin that lies on
// edge becomes smaller than its lid.
constexpr double kMaxNarrowed = 0.05;
// chosen: steps of a hundredth of the radius each.
constexpr int kNarrowings = 5;
// chosen: the least share of the entering rays that narrowing must clear. When no more than this
// share is left, the rest is noise.
constexpr double kMinCleared = 1.0 / 3;

// The mean radius of a cylinder or cone; 0 for other shapes.
double RadiusOf(const Shape& shape) {
  if (const auto* cylinder = std::get_if<Cylinder>(&shape)) return cylinder->radius_m;
  const auto* cone = std::get_if<Cone>(&shape);
  return cone == nullptr ? 0 : 0.5 * (cone->radius_bottom_m + cone->radius_top_m);
}

// The solid with its radius smaller by by_m and its axis moved as far in the direction `toward`, a
// unit vector across the axis toward the sensor.
Solid Narrowed(const Solid& solid, const Vector3& toward, double by_m) {
  Solid out = solid;
  out.X_MS.translation() += by_m * toward;
  if (auto* cylinder = std::get_if<Cylinder>(&out.shape)) cylinder->radius_m -= by_m;
  if (auto* cone = std::get_if<Cone>(&out.shape)) {
    cone->radius_bottom_m = std::max(0.0, cone->radius_bottom_m - by_m);
    cone->radius_top_m = std::max(0.0, cone->radius_top_m - by_m);
  }
  return out;
}

// Adds the change of each coefficient to its standard deviation.
void WidenSigmas(const Solid& before, Solid& after) {
  const std::vector<double> from = Coefficients(before.shape, before.X_MS);
  const std::vector<double> to = Coefficients(after.shape, after.X_MS);
  std::vector<double>& sigma = after.parameter_sigma;
  if (from.size() != sigma.size() || to.size() != sigma.size()) return;
  for (std::size_t k = 0; k < sigma.size(); ++k) sigma[k] = std::hypot(sigma[k], to[k] - from[k]);
}

void ShrinkRoundSolid(const FitContext& c, Solid& solid) {
  const double radius_m = RadiusOf(solid.shape);
  if (!(radius_m > 0) || solid.vessel) return;
  const double at_first = CrossingRayShare(solid, c.free);
  if (at_first < kMixedPixels) return;  // a correct outline has mixed pixels too
  const Vector3 axis = solid.X_MS.linear().col(2);
  Vector3 toward = c.points.viewpoint - solid.X_MS.translation();
  toward -= toward.dot(axis) * axis;
  if (!(toward.norm() > radius_m)) return;  // the sensor looks along the axis
  toward.normalize();
  const double worthwhile = (1 - kMinCleared) * at_first;
  double min_share = worthwhile;
  Solid clearest;
  for (int step = 1; step <= kNarrowings && min_share > kMinCleared * at_first; ++step) {
    c.work.Poll();
    Solid narrowed = Narrowed(solid, toward, step * kMaxNarrowed / kNarrowings * radius_m);
    const double now = CrossingRayShare(narrowed, c.free);
    if (now < min_share) min_share = now, clearest = std::move(narrowed);
  }
  if (!(min_share < worthwhile)) return;
  WidenSigmas(solid, clearest);
  solid = std::move(clearest);
}

}  // namespace

void ShrinkToFreeSpace(const FitContext& context, std::span<Solid> solids) {
  for (Solid& solid : solids) {
    context.work.Poll();
    ShrinkRoundSolid(context, solid);
  }
}

}  // namespace cwm::perception
