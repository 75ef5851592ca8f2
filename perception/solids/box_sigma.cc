#include "perception/solids/box_sigma.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "perception/cloud/tolerances.h"

namespace cwm::perception {
namespace {

// derived: 45 degrees between a point's normal and the face's, so that no other face is nearer.
constexpr double kFace_cos = std::numbers::sqrt2 / 2;
// derived: the depth of the space beyond an end that free rays must cross to show that the face
// ends there. A face that continued could have lost points at its edge over this length.
constexpr double kBeyond_m = kEdgeLoss_m;
// chosen: the position of an outline is known to about the pixel that it crosses.
constexpr double kOutline_px = 0.7;

struct End {
  int axis = 0;
  double side = 1;  // -1 for the low end
};

// Data that all ends of a box share.
struct BoxView {
  const FitContext& c;
  const Solid& solid;
  Vector3 half_m;
  Pose X_SM;
  double pitch_m = 0;  // between neighbouring pixels

  BoxView(const Solid& box, const FitContext& context)
      : c(context),
        solid(box),
        half_m(0.5 * std::get<Box>(box.shape).size_m),
        X_SM(box.X_MS.inverse(Eigen::Isometry)),
        pitch_m(context.points.spacing_m / std::sqrt(context.points.weight)) {}
};

// The standard deviation of the mean distance of the points on the face; empty if there are too
// few.
std::optional<double> FaceSigma_m(const BoxView& box, const End& end) {
  const Vector3 outward = end.side * box.X_SM.linear().row(end.axis).transpose();
  double count = 0, squares = 0;
  for (std::uint32_t i : box.solid.inliers) {
    const double height_m =
        end.side * (box.X_SM * box.c.points.p[i])(end.axis) - box.half_m(end.axis);
    if (std::abs(height_m) > box.c.points.gate_m[i]) continue;
    if (outward.dot(box.c.points.n[i]) < kFace_cos) continue;
    count += 1;
    squares += box.c.points.sigma_m[i] * box.c.points.sigma_m[i];
  }
  if (count * box.c.points.weight < kTwoSamples) return std::nullopt;
  return std::sqrt(squares / count / std::max(1.0, box.c.IndependentSamples(count)));
}

bool StandsOn(const BoxView& box, const End& end) {
  if (!box.c.ground.known) return false;
  const Vector3 p =
      box.solid.X_MS * Vector3(end.side * box.half_m(end.axis) * Vector3::Unit(end.axis));
  const Vector3 outward = end.side * box.solid.X_MS.linear().col(end.axis);
  return outward.dot(box.c.ground.up) < -std::cos(kSameDirection_rad) &&
         box.c.ground.Height_m(p) < kStandingGap_m;
}

// True if a ray passed through the space into which the box would continue.
bool IsFreeBeyond(const BoxView& box, const End& end) {
  Vector3 size_m = 2 * box.half_m;
  size_m(end.axis) = kBeyond_m;
  Pose X_BM = box.X_SM;
  X_BM.pretranslate(-end.side * (box.half_m(end.axis) + 0.5 * kBeyond_m) * Vector3::Unit(end.axis));
  const Shape beyond = Box{.size_m = size_m};
  const DistanceToShape distance_m(beyond);
  return std::any_of(box.c.free.rays.begin(), box.c.free.rays.end(), [&](const FreeRay& ray) {
    return FindNearestRayPoint(distance_m, X_BM, ray).clearance_m < 0;
  });
}

std::optional<double> EndSigma_m(const BoxView& box, const End& end) {
  if (const auto face = FaceSigma_m(box, end)) return face;
  if (StandsOn(box, end)) return 0.0;
  if (IsFreeBeyond(box, end)) return kOutline_px * box.pitch_m;
  return std::nullopt;
}

double SizeSigma_m(const BoxView& box, int axis) {
  const auto low = EndSigma_m(box, {axis, -1}), high = EndSigma_m(box, {axis, 1});
  if (!low || !high) return 0;
  const Vector3 along = box.solid.X_MS.linear().col(axis);
  const Vector3 ray = (box.solid.X_MS.translation() - box.c.points.viewpoint).normalized();
  const double apart = 2 * box.half_m(axis) / kWarpCorrelation_m;
  const double warp_m = box.c.noise.WarpSigma_m() * std::abs(along.dot(ray)) *
                        std::sqrt(2 * (1 - std::exp(-0.5 * apart * apart)));
  return std::hypot(*low, *high, warp_m);
}

}  // namespace

std::vector<double> BoxSizeSigmas(const Solid& box, const FitContext& context) {
  if (!std::holds_alternative<Box>(box.shape)) return {};
  const BoxView view(box, context);
  return {SizeSigma_m(view, 0), SizeSigma_m(view, 1), SizeSigma_m(view, 2)};
}

}  // namespace cwm::perception
