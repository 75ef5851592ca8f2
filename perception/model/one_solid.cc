#include "perception/model/one_solid.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "perception/model/model_selection.h"
#include "perception/model/observed.h"
#include "perception/model/whole_fit.h"

namespace cwm::perception {
namespace {

constexpr double kLeastExplained = 0.9;  // of the points; what is left of them is meshed
constexpr double kPositive = 2;          // evidence, as kDecisive is (Kass and Raftery 1995)
// Of the whole surface: half of it faces away, and what hides seven tenths of the rest leaves 0.15;
// half of that, for the foot in the support's band and for rims at grazing incidence.
constexpr double kLeastSeen = 0.08;

bool IsSought(WholeKind kind, const ModelerOptions& options) {
  switch (kind) {
    case WholeKind::kBall:
      return options.search_spheres;
    case WholeKind::kUprightCylinder:
    case WholeKind::kLyingCylinder:
      return options.search_cylinders;
    case WholeKind::kUprightCone:
    case WholeKind::kLyingCone:
      return options.search_cones;
    case WholeKind::kUprightBox:
    case WholeKind::kTiltedBox:
      return options.search_planes;
  }
  return false;
}

// Of an assembled solid, for comparison with those of the whole kinds.
int DegreesOfFreedom(const Shape& shape) {
  if (std::holds_alternative<Sphere>(shape)) return 4;
  if (std::holds_alternative<Cylinder>(shape)) return 5;
  // Its plane, its thickness, and its corners, which follow the noise of the border.
  if (const auto* plate = std::get_if<Plate>(&shape)) {
    return 4 + static_cast<int>(plate->outline.size());
  }
  return 6;
}

Account AccountOf(const std::vector<Solid>& solids, const FitContext& c) {
  int parameters = 0;
  for (const Solid& solid : solids) parameters += DegreesOfFreedom(solid.shape);
  return AccountOf(solids, parameters, c);
}

bool HasWorthySlope(const WholeFit& fit, const FitContext& c) {
  if (!IsConical(fit.kind)) return true;
  const Eigen::Index last = fit.parameters.size() - 1;
  const double sigma = std::sqrt(CovarianceOf(fit, c)(last, last));
  return std::abs(SlopeOf(fit.kind, fit.parameters)) >
         std::max(kLeastSlope, kLeastSlope_sigma * sigma);
}

// The curved surface of a round solid; nothing of a box.
std::optional<AnyModel> CurvedModelOf(const Solid& solid) {
  const Vector3 at = solid.X_MS.translation();
  const Vector3 axis = solid.X_MS.linear().col(2);
  if (const auto* sphere = std::get_if<Sphere>(&solid.shape)) {
    return SphereModel{.center = at, .radius_m = sphere->radius_m};
  }
  if (const auto* cylinder = std::get_if<Cylinder>(&solid.shape)) {
    return CylinderModel{.point = at, .axis = axis, .radius_m = cylinder->radius_m};
  }
  if (const auto* cone = std::get_if<Cone>(&solid.shape)) {
    return ConeModel{.point = at,
                     .axis = axis,
                     .radius_m = 0.5 * (cone->radius_bottom_m + cone->radius_top_m),
                     .slope = (cone->radius_top_m - cone->radius_bottom_m) / cone->length_m};
  }
  return std::nullopt;
}

// Whether what is seen of it is as curved as it is.
bool LooksCurved(const Solid& solid, const FitContext& c) {
  const std::optional<AnyModel> model = CurvedModelOf(solid);
  if (!model) return true;
  ShapeFit fit{.model = *model, .inliers = {}, .covariance = {}, .covered = {}};
  for (std::uint32_t i : solid.inliers) {
    if (std::abs(Distance_m(*model, c.points.p[i])) <= c.points.gate_m[i]) fit.inliers.push_back(i);
  }
  return !fit.inliers.empty() && IsSignificantlyCurved(fit, c);
}

double SeenShare(const Solid& solid, const FitContext& c) {
  const Pose X_SM = solid.X_MS.inverse(Eigen::Isometry);
  std::vector<Eigen::Vector3f> points_S;
  for (std::uint32_t i : solid.inliers) points_S.push_back((X_SM * c.points.p[i]).cast<float>());
  return ObservedFraction(solid.shape, points_S, CoverCell_m(c.points.spacing_m));
}

bool IsCredible(const WholeFit& fit, const FitContext& c) {
  const auto all = static_cast<double>(c.points.size());
  return static_cast<double>(fit.solid.inliers.size()) >= kLeastExplained * all &&
         HasWorthySlope(fit, c) && LooksCurved(fit.solid, c) &&
         SeenShare(fit.solid, c) >= kLeastSeen && !IsCrossed(fit.solid, c);
}

bool IsAlready(const std::vector<Solid>& solids, const Shape& shape) {
  return solids.size() == 1 && KindOf(solids.front().shape) == KindOf(shape);
}

}  // namespace

void PreferOneSolid(const FitContext& context, Assembly& assembly) {
  if (!context.ground.known) return;
  std::vector<Solid> known = assembly.solids;
  // What to beat: the solids as they are, and the best whole one of the kind that they are already.
  const Account assembled = AccountOf(assembly.solids, context);
  double rival = assembled.value - kDecisive;
  std::optional<WholeFit> best;
  double best_value = rival;
  for (WholeKind kind : {WholeKind::kBall, WholeKind::kUprightCylinder, WholeKind::kUprightCone,
                         WholeKind::kLyingCylinder, WholeKind::kLyingCone, WholeKind::kUprightBox,
                         WholeKind::kTiltedBox}) {
    if (!IsSought(kind, context.options)) continue;
    std::optional<WholeFit> fit = FitWhole(kind, known, assembled.loss, context);
    if (!fit) continue;
    known.push_back(fit->solid);  // a cone may grow out of a cylinder
    if (IsAlready(assembly.solids, fit->solid.shape)) {
      if (HasWorthySlope(*fit, context)) rival = std::min(rival, fit->value - kPositive);
      continue;
    }
    const double value = fit->value + (Lies(kind) ? kUprightPrior : 0);
    if (value < best_value && IsCredible(*fit, context)) best = std::move(fit), best_value = value;
  }
  if (!best || best_value >= rival) return;
  best->solid.parameter_sigma = CoefficientSigmas(*best, CovarianceOf(*best, context), context);
  assembly.solids = {std::move(best->solid)};
}

}  // namespace cwm::perception
