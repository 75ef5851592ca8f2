#include "perception/primitive_fit/single_primitive.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "collision/geometry/aabb.h"
#include "collision/geometry/signed_distance.h"
#include "perception/cloud/oriented_points.h"
#include "perception/cloud/parallel_for.h"
#include "perception/cloud/tolerances.h"
#include "perception/fit/model_selection.h"
#include "perception/primitive_fit/primitive_fit.h"
#include "perception/primitive_fit/primitive_fit_misfit.h"
#include "perception/solids/free_space.h"
#include "perception/solids/observed.h"
#include "perception/solids/round_solid.h"

namespace cwm::perception {
namespace {

// cited: positive evidence, on the scale that kDecisive is taken from (Kass and Raftery 1995).
constexpr double kPositive = 3;
// chosen: twice the logarithm of the number of upright objects per lying one.
constexpr double kLyingPrior = 4;
// chosen: an assembled solid that is farther from upright or level leans.
constexpr double kTurned_rad = 0.1;
// derived: the least observed share of the whole surface. Half of it faces away, and an occluder of
// seven tenths of the rest leaves 0.15; two thirds of that allow for the foot in the support's band
// and for rims at grazing incidence.
constexpr double kMinSeen = 0.1;
// chosen: of an upright cylinder seen from above little more than its top is visible. The top
// constrains all but its height, which the ground gives.
constexpr double kMinSeenUpright = 0.07;
// derived: in standard deviations of the curvature that noise gives flat patches. The strip of a
// rod needs half of what an isolated patch needs, because the criterion has compared the whole rod
// with boxes.
constexpr double kMinCurved_sigma = kMinCurvature_sigma / 2;
// chosen: the largest share of a solid's volume that may lie deep in another. Solids of touching
// objects share less.
constexpr double kMaxShared = 0.25;
// chosen: samples per side of a solid's bounds for its volume; a ball holds about a hundred.
constexpr int kPlacesPerSide = 6;

// The prior of a fit's pose. Boxes get the same prior as round solids; otherwise a leaning or lying
// rod would become a box wherever both fit it.
double PriorOf(const PrimitiveFit& fit) {
  switch (fit.kind) {
    case PrimitiveKind::kLeaningCylinder:
    case PrimitiveKind::kTiltedBox:
      return kUprightPrior;
    case PrimitiveKind::kUprightBox: {
      const Vector3& size_m = std::get<Box>(fit.solid.shape).size_m;
      return size_m.head<2>().maxCoeff() > size_m.z() ? kLyingPrior : 0;
    }
    default:
      return IsLying(fit.kind) ? kLyingPrior : 0;
  }
}

// The same prior for an assembled solid.
double PriorOf(const Solid& solid, const Vector3& up) {
  const Vector3 rise = solid.X_MS.linear().transpose() * up;  // sine of each axis' elevation
  if (const auto* box = std::get_if<Box>(&solid.shape)) {
    Eigen::Index upright = 0;
    if (rise.cwiseAbs().maxCoeff(&upright) < std::cos(kTurned_rad)) return kUprightPrior;
    return box->size_m.maxCoeff() > box->size_m(upright) ? kLyingPrior : 0;
  }
  double slope = 0;
  if (const auto* cone = std::get_if<Cone>(&solid.shape)) {
    slope = (cone->radius_top_m - cone->radius_bottom_m) / cone->length_m;
  } else if (!std::holds_alternative<Cylinder>(solid.shape)) {
    return 0;
  }
  if (std::abs(rise.z()) > std::cos(kTurned_rad)) return 0;
  const double leans_rad = std::abs(std::asin(std::clamp(rise.z(), -1.0, 1.0)) - std::atan(slope));
  return leans_rad > kTurned_rad ? kUprightPrior : kLyingPrior;
}

// The kinds that reduced effort seeks: most objects are of these, and they take the fewest starts.
bool IsSearchedAtReducedEffort(PrimitiveKind kind) {
  return kind == PrimitiveKind::kBall || kind == PrimitiveKind::kUprightCylinder ||
         kind == PrimitiveKind::kUprightBox;
}

bool IsSearched(PrimitiveKind kind, const ModelerOptions& options) {
  if (options.reduced_effort && !IsSearchedAtReducedEffort(kind)) return false;
  switch (kind) {
    case PrimitiveKind::kBall:
      return options.search_spheres;
    case PrimitiveKind::kUprightCylinder:
    case PrimitiveKind::kLyingCylinder:
    case PrimitiveKind::kLeaningCylinder:
      return options.search_cylinders;
    case PrimitiveKind::kUprightCone:
    case PrimitiveKind::kLyingCone:
      return options.search_cones;
    case PrimitiveKind::kUprightBox:
    case PrimitiveKind::kTiltedBox:
      return options.search_planes;
  }
  return false;
}

// Degrees of freedom of an assembled solid, for comparison with those of fitted kinds.
int DegreesOfFreedom(const Shape& shape) {
  if (std::holds_alternative<Sphere>(shape)) return 4;
  if (std::holds_alternative<Cylinder>(shape)) return 5;
  // The plane, the thickness, and the corners, which follow the noise of the border.
  if (const auto* plate = std::get_if<Plate>(&shape)) {
    return 4 + static_cast<int>(plate->outline.size());
  }
  return 6;
}

// True unless the fit is a cone so flat that it is a cylinder. The criterion decides whether a
// steeper slope is worth its parameter.
bool HasWorthySlope(const PrimitiveFit& fit) {
  return !IsConical(fit.kind) || std::abs(SlopeOf(fit.kind, fit.parameters)) > kMinSlope;
}

// The curved surface of a round solid; empty for others.
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

// True if the visible part of a round solid is significantly curved; true for all other solids.
bool LooksCurved(const Solid& solid, const FitContext& c) {
  const std::optional<AnyModel> model = CurvedModelOf(solid);
  if (!model) return true;
  ShapeFit fit{.model = *model, .inliers = {}, .covariance = {}, .covered = {}};
  for (std::uint32_t i : solid.inliers) {
    if (std::abs(Distance_m(*model, c.points.p[i])) <= c.points.gate_m[i]) fit.inliers.push_back(i);
  }
  return !fit.inliers.empty() && IsSignificantlyCurved(fit, c, kMinCurved_sigma);
}

double SeenShare(const Solid& solid, const FitContext& c) {
  const Pose X_SM = solid.X_MS.inverse(Eigen::Isometry);
  std::vector<Eigen::Vector3f> points_S;
  for (std::uint32_t i : solid.inliers) points_S.push_back((X_SM * c.points.p[i]).cast<float>());
  return ObservedFraction(solid.shape, points_S, CoverCell_m(c.points.spacing_m));
}

double MinSeenShare(PrimitiveKind kind) {
  return kind == PrimitiveKind::kUprightCylinder ? kMinSeenUpright : kMinSeen;
}

bool IsCredible(const PrimitiveFit& fit, const FitContext& c) {
  const auto all = static_cast<double>(c.points.size());
  return static_cast<double>(fit.solid.inliers.size()) >= kNearlyAll * all && HasWorthySlope(fit) &&
         LooksCurved(fit.solid, c) && LooksFlat(fit.solid, c) &&
         CrossingRayShare(fit.solid, c.free) <= kMaxPassedBeside && !IsCrossed(fit.solid, c) &&
         SeenShare(fit.solid, c) >= MinSeenShare(fit.kind);
}

int DegreesOfFreedom(const std::vector<Solid>& solids) {
  int sum = 0;
  for (const Solid& solid : solids) sum += DegreesOfFreedom(solid.shape);
  return sum;
}

struct ScoredFit {
  PrimitiveFit fit;
  double value = 0;  // including the prior of its pose
};

// The value that a fit must beat: by kPositive, or by anything if the fit has fewer parameters or
// is a cone. The criterion's penalty for the slope is enough for cones, because cups are as common
// as cans; with a margin, two cups became cans for each can that became a cup.
struct Alternative {
  double value = std::numeric_limits<double>::infinity();
  int parameters = 0;

  bool IsBeatenBy(const PrimitiveFit& fit, double its_value) const {
    const bool by_any = fit.parameters.size() < parameters || IsConical(fit.kind);
    return its_value < value - (by_any ? 0 : kPositive);
  }
};

// The largest ratio of a fit's value to that of an assembled solid of the same kind at which the
// fit is preferred. It replaces faces that were taken for the whole, and cans and cups whose width
// the lid and the rays beside them constrain better than the wall does. If the values differ by
// less, a box is known better from its faces; a ball consists of its wall alone.
double MaxValueRatio(const PrimitiveFit& fit) {
  switch (KindOf(fit.solid.shape)) {
    case ShapeKind::kCone:
      return 1;
    case ShapeKind::kCylinder:
      return kMaxCylinderValueRatio;
    default:
      return kMaxValueRatio;
  }
}

bool IsSingleOfKind(const std::vector<Solid>& solids, const Shape& shape) {
  return solids.size() == 1 && KindOf(solids.front().shape) == KindOf(shape);
}

// True if more than kMaxShared of a's volume lies deep in b.
bool Overlap(const Solid& a, const Solid& b) {
  if (!TightBounds(a.shape, a.X_MS).intersects(TightBounds(b.shape, b.X_MS))) return false;
  const Aabb bounds = TightBounds(a.shape, Pose::Identity());
  const Pose X_BA = b.X_MS.inverse(Eigen::Isometry) * a.X_MS;
  int inside = 0, shared = 0;
  for (int k = 0; k < kPlacesPerSide * kPlacesPerSide * kPlacesPerSide; ++k) {
    const int row = k / kPlacesPerSide % kPlacesPerSide;
    const int layer = k / (kPlacesPerSide * kPlacesPerSide);
    const Vector3 cell(k % kPlacesPerSide, row, layer);
    const Vector3 share = (cell + Vector3::Constant(0.5)) / kPlacesPerSide;
    const Vector3 p = bounds.min() + share.cwiseProduct(bounds.sizes());
    if (SignedDistance_m(a.shape, p) > 0) continue;
    ++inside;
    shared += SignedDistance_m(b.shape, X_BA * p) < -kMaxDepth_m;
  }
  return shared > kMaxShared * inside;
}

// The points of each solid: each point belongs to the nearest solid within its gate.
std::vector<std::vector<std::uint32_t>> PointsPerSolid(const std::vector<Solid>& solids,
                                                       const ModelPoints& points) {
  std::vector<std::vector<std::uint32_t>> members(solids.size());
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    double nearest_m = points.gate_m[i];
    std::size_t nearest = solids.size();
    for (std::size_t k = 0; k < solids.size(); ++k) {
      const Vector3 p_S = solids[k].X_MS.inverse(Eigen::Isometry) * points.p[i];
      const double distance_m = std::abs(SignedDistance_m(solids[k].shape, p_S));
      if (distance_m <= nearest_m) nearest = k, nearest_m = distance_m;
    }
    if (nearest < solids.size()) members[nearest].push_back(i);
  }
  return members;
}

// True if few rays enter the disc, it does not reach below the plate (whose part below the ground
// was cut off), and the criterion prefers it to the plate.
bool IsCredibleDisc(const Solid& disc, const Solid& plate, const FitContext& c) {
  if (CrossingRayShare(disc, c.free) > kMaxPassedBeside) return false;
  if (c.ground.known &&
      LowestHeight_m(disc, c.ground) < LowestHeight_m(plate, c.ground) - kGroundNoise_m) {
    return false;
  }
  return FitScoreOf({disc}, c).value <= FitScoreOf({plate}, c).value;
}

// The replacement of a solid of all the context's points: the best closed solid if there is one, or
// the disc if the solid is a lone round face. The disc wins over nothing, and over a box with a
// worse value.
std::optional<Solid> Replacement(const Solid& solid, const FitContext& c) {
  std::optional<Solid> disc = MakeDisc(solid, c);
  if (disc && !IsCredibleDisc(*disc, solid, c)) disc.reset();
  std::optional<PrimitiveFit> better = FindBetterPrimitive(c, {solid});
  const bool is_box = better && std::holds_alternative<Box>(better->solid.shape);
  if (disc && (!better || (is_box && FitScoreOf({*disc}, c).value < better->value))) return disc;
  if (!better) return std::nullopt;
  return WithParameterSigmas(*std::move(better), c);
}

// Replaces each of several solids by itself: objects that touch may be one object.
void ReplaceEachByPrimitive(const FitContext& c, std::vector<Solid>& solids) {
  const auto members = PointsPerSolid(solids, c.points);
  const auto prefer_one = [&](std::size_t k) {
    const ModelPoints own = Subset(c.points, members[k]);
    if (static_cast<double>(own.size()) * own.weight < c.options.min_inliers) return;
    const FitContext alone{own,       c.octree, c.connectivity, c.noise,
                           c.options, c.work,   c.ground,       c.free};
    Solid solid = solids[k];
    solid.inliers.resize(members[k].size());
    std::iota(solid.inliers.begin(), solid.inliers.end(), std::uint32_t{0});
    std::optional<Solid> better = Replacement(solid, alone);
    if (!better) return;
    for (std::uint32_t& i : better->inliers) i = members[k][i];
    if (!IsCrossed(*better, c)) solids[k] = *std::move(better);
  };
  ParallelFor(solids.size(), 1, c.work, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) prefer_one(k);
  });
}

}  // namespace

bool LooksFlat(const Solid& solid, const FitContext& c) {
  // chosen: the least significant sagitta of a curved surface, besides unevenness (IsSignificant).
  constexpr double kMinBend_sigma = 0.5;
  const auto* box = std::get_if<Box>(&solid.shape);
  if (box == nullptr) return true;
  Eigen::Index thin = 0;
  if (box->size_m.minCoeff(&thin) > 2 * c.points.max_gate_m) return true;
  const Eigen::Index across = (thin + 1) % 3, along = (thin + 2) % 3;
  const Vector3 half = 0.5 * box->size_m;
  const Pose X_SM = solid.X_MS.inverse(Eigen::Isometry);
  constexpr int kTerms = QuadricTerms::SizeAtCompileTime;
  using Square = Eigen::Matrix<double, kTerms, kTerms>;
  Square square = Square::Zero();
  QuadricTerms toward = QuadricTerms::Zero();
  double sigma_m = 0;
  std::size_t count = 0;
  for (std::uint32_t i : solid.inliers) {
    const Vector3 p = X_SM * c.points.p[i];
    const Vector3 to_face = half - p.cwiseAbs();
    if (to_face[thin] > to_face[across] || to_face[thin] > to_face[along]) continue;
    const double x = p[across] / half[across], y = p[along] / half[along];
    const QuadricTerms terms{1, x, y, x * x, x * y, y * y};
    square += terms * terms.transpose();
    toward += p[thin] * terms;
    sigma_m += c.points.sigma_m[i];
    ++count;
  }
  if (count < kTerms) return true;
  sigma_m /= static_cast<double>(count);
  square.diagonal().array() += kMinInformation * static_cast<double>(count);
  const Eigen::LDLT<Square> solver(square);
  const QuadricTerms quadric = solver.solve(toward);
  const QuadricTerms variance =
      solver.solve(Square::Identity()).diagonal() *
      (static_cast<double>(count) / std::max(1.0, c.IndependentSamples(count)));
  const auto is_bent = [&](Eigen::Index k) {
    // How far the quadric through the points bends from the middle to a side. Warp moves both ends.
    const double bend_m = std::abs(quadric[k]);
    return bend_m > double{kUnevenness_m} + kMinBend_sigma * sigma_m + 2 * c.noise.WarpSigma_m() +
                        kMinCurvature_sigma * sigma_m * std::sqrt(variance[k]);
  };
  return !is_bent(3) && !is_bent(5);
}

FitScore FitScoreOf(const std::vector<Solid>& solids, const FitContext& c) {
  return FitScoreOf(solids, DegreesOfFreedom(solids), c);
}

std::optional<PrimitiveFit> FindBetterPrimitive(const FitContext& context,
                                                const std::vector<Solid>& solids) {
  std::vector<Solid> known = solids;
  // A fit must beat the solids as they are, and the best fit of the kind that a single solid has.
  const FitScore assembled =
      FitScoreOf(AnyOverlap(solids) ? std::vector<Solid>() : solids, context);
  const double prior = solids.size() == 1 ? PriorOf(solids.front(), context.ground.up) : 0;
  const Alternative assembled_solids{assembled.value + prior, DegreesOfFreedom(solids)};
  Alternative of_same_kind;
  FitScore best_so_far = assembled;  // a start's loss must come near this one's
  std::optional<ScoredFit> best, same;
  for (PrimitiveKind kind :
       {PrimitiveKind::kBall, PrimitiveKind::kUprightCylinder, PrimitiveKind::kUprightCone,
        PrimitiveKind::kLyingCylinder, PrimitiveKind::kLyingCone, PrimitiveKind::kLeaningCylinder,
        PrimitiveKind::kUprightBox, PrimitiveKind::kTiltedBox}) {
    if (!IsSearched(kind, context.options)) continue;
    std::optional<PrimitiveFit> fit = FitPrimitive(kind, known, best_so_far, context);
    if (!fit) continue;
    known.push_back(fit->solid);  // a cone may start from a cylinder
    const double value = fit->value + PriorOf(*fit);
    if (IsSingleOfKind(solids, fit->solid.shape)) {
      if (HasWorthySlope(*fit) && value < of_same_kind.value) {
        of_same_kind = {value, static_cast<int>(fit->parameters.size())};
      }
      if (!same || value < same->value) same = ScoredFit{*std::move(fit), value};
      continue;
    }
    if (best && value >= best->value) continue;
    if (assembled_solids.IsBeatenBy(*fit, value) && IsCredible(*fit, context)) {
      best_so_far.loss = std::min(best_so_far.loss, fit->loss);
      best = ScoredFit{*std::move(fit), value};
    }
  }
  std::optional<PrimitiveFit> kept;
  if (best && of_same_kind.IsBeatenBy(best->fit, best->value)) {
    kept = std::move(best->fit);
  } else if (same && same->value < MaxValueRatio(same->fit) * assembled_solids.value &&
             IsCredible(same->fit, context)) {
    kept = std::move(same->fit);
  }
  if (kept) RefineOnMorePoints(context, *kept);
  return kept;
}

std::optional<PrimitiveFit> Refit(const PrimitiveFit& fit, const FitContext& context) {
  const FitScore none = FitScoreOf({}, context);
  std::optional<PrimitiveFit> anew = FitPrimitive(fit.kind, {fit.solid}, none, context);
  if (!anew || anew->value + PriorOf(*anew) >= none.value - kPositive ||
      !IsCredible(*anew, context)) {
    return std::nullopt;
  }
  return anew;
}

Solid WithParameterSigmas(PrimitiveFit fit, const FitContext& context) {
  fit.solid.parameter_sigma = CoefficientSigmas(fit, CovarianceOf(fit, context), context);
  return std::move(fit.solid);
}

bool AnyOverlap(const std::vector<Solid>& solids) {
  for (std::size_t a = 0; a < solids.size(); ++a) {
    for (std::size_t b = 0; b < solids.size(); ++b) {
      if (a != b && Overlap(solids[a], solids[b])) return true;
    }
  }
  return false;
}

void ReplaceBySinglePrimitive(const FitContext& context, Assembly& assembly) {
  if (!context.ground.known) return;
  if (assembly.solids.size() == 1) {
    if (std::optional<Solid> better = Replacement(assembly.solids.front(), context)) {
      assembly.solids = {*std::move(better)};
    }
  } else if (std::optional<PrimitiveFit> better = FindBetterPrimitive(context, assembly.solids)) {
    assembly.solids = {WithParameterSigmas(*std::move(better), context)};
  } else {
    ReplaceEachByPrimitive(context, assembly.solids);
  }
}

}  // namespace cwm::perception
