#include "perception/primitive_fit/primitive_fit.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "collision/geometry/aabb.h"
#include "collision/geometry/coefficients.h"
#include "collision/geometry/distance_to_shape.h"
#include "perception/cloud/tolerances.h"
#include "perception/fit/refine.h"
#include "perception/primitive_fit/primitive_fit_ends.h"
#include "perception/primitive_fit/primitive_fit_limits.h"
#include "perception/primitive_fit/primitive_fit_misfit.h"
#include "perception/primitive_fit/primitive_fit_starts.h"
#include "perception/primitive_fit/solid_lanes.h"

namespace cwm::perception {
namespace {

// chosen: as a share of the points within their gates during the descent. A fit with fewer is given
// up.
constexpr double kMinFitInlierShare = 0.85;

// derived: the chosen fit is refined on four times as many points, which halves its independent
// error. The axes of lying solids improve by a tenth; 4 000 points are no better.
constexpr std::size_t kRefinementPoints = kUsedPoints * 4;
// chosen: points for comparing starts. The best start only has to be near the solution.
constexpr std::size_t kStartPoints = 80;
// chosen: scales of the loss, in standard deviations: wide first, to draw in distant starts, then
// as narrow as mixed pixels require.
constexpr std::array<double, 3> kScales_sigma = {10, 4, 2.5};
// derived: the variance of an estimate at the narrowest scale, relative to what its weights
// suggest, for normally distributed residuals (their mean weight is 0.80, the efficiency 0.86). If
// the residuals are much wider than stated, their weighted mean square is used instead.
constexpr double kVariance = 0.93;
// chosen: steps taken from every start before the starts are compared.
constexpr int kStepsOfStart = 3;
// chosen: steps at each scale from the best start; the descent may stop sooner (kMinLossDecrease).
constexpr int kStepsPerScale = 8;
// chosen: as a multiple of the alternative's loss. A kind whose best start is worse is given up.
constexpr double kMaxStartLossRatio = 3;
// chosen: attempts to find a damping that lowers the loss, also across the creases of a surface.
constexpr int kMaxDampings = 6;
// chosen: a step that lowers the loss by a smaller share than this is the last.
constexpr double kMinLossDecrease = 1e-3;
// derived: the residual of a point if there is no solid: so large that it is truncated, with a
// finite square.
constexpr double kNoSolidResidual_sigma = 1e6;
// Rays per independent sample past a lying solid. Past its round side the blur of the outline is
// mostly independent between pixels, more so than the noise of a surface. Past the flat lids of
// upright solids a real Kinect shows up to 5 pixels of background over the far rim, so there rays
// count no more than points.
// chosen: on 500 simulated scenes; with 1 mixed pixels count too much.
constexpr double kRaysPerSampleLying = 2.4;
// chosen: in rays per sample. If the rays that a fit crosses cost less than this in the criterion,
// no second fit with rays is made.
constexpr double kMinRayCost = 2;
// chosen: the clearance up to which rays take part in a fit. It is half of the length that a ray's
// places span (ResampledAround); the steps that rays cause are smaller.
constexpr double kMaxRayClearance_m = 0.02;

PointsOnGround OnGround(const FitContext& c, std::size_t max_points = kUsedPoints) {
  PointsOnGround out;
  out.X_MG.linear() = BasisFromZ(c.ground.up);
  out.X_MG.translation() = -c.ground.Height_m(Vector3::Zero()) * c.ground.up;
  const Pose X_GM = out.X_MG.inverse(Eigen::Isometry);
  out.viewpoint_G = X_GM * c.points.viewpoint;
  const std::size_t stride = (c.points.size() + max_points - 1) / max_points;
  for (std::size_t i = 0; i < c.points.size(); i += stride) {
    out.p_G.push_back(X_GM * c.points.p[i]);
    out.sigma_m.push_back(c.points.sigma_m[i]);
  }
  return out;
}

// The evidence of a fit: points on its surface, and rays that it must not reach.
struct Evidence {
  PointsOnGround points;
  std::vector<FreeRay> rays_G;
  PlaceLanes points_G, places_G;  // the same points; then the places of each ray in turn
  double ray_weight = 1;          // of one ray, in points used
  double slope_weight = 0;        // of the prior kSlopeSpread, likewise
};

double Depth_sigma(double clearance_m, const FreeRay& ray) {
  return std::max(0.0, -clearance_m) / ray.sigma_m;
}

Evidence PointsAlone(PointsOnGround points) {
  Evidence evidence{.points = std::move(points),
                    .rays_G = {},
                    .points_G = PlaceLanes(),
                    .places_G = PlaceLanes()};
  evidence.points_G = PlaceLanes(evidence.points.p_G);
  return evidence;
}

// The residuals in standard deviations: of the points, then the depths of the rays, then a cone's
// slope.
Eigen::VectorXd Residuals(PrimitiveKind kind, const PrimitiveParameters& x,
                          const Evidence& evidence) {
  const PlacedPrimitive solid = Place(kind, x);
  const Pose X_SG = solid.X_GS.inverse(Eigen::Isometry);
  const std::size_t points = evidence.points_G.size();
  Eigen::VectorXd r(static_cast<Eigen::Index>(points + evidence.rays_G.size() + 1));
  evidence.points_G.DistancesTo(solid.shape, X_SG, {r.data(), points});
  Eigen::Index k = 0;
  for (double sigma_m : evidence.points.sigma_m) r(k++) /= sigma_m;
  std::vector<double> places_m(evidence.places_G.size());
  evidence.places_G.DistancesTo(solid.shape, X_SG, places_m);
  auto place = places_m.begin();
  for (const FreeRay& ray : evidence.rays_G) {
    r(k++) = Depth_sigma(*std::min_element(place, place + kSamplesPerRay), ray);
    place += kSamplesPerRay;
  }
  r(k) = SlopeOf(kind, x) / kSlopeSpread;
  return r;
}

Eigen::VectorXd CountsOf(const Evidence& evidence) {
  const auto points = static_cast<Eigen::Index>(evidence.points.p_G.size());
  const auto rays = static_cast<Eigen::Index>(evidence.rays_G.size());
  Eigen::VectorXd counts = Eigen::VectorXd::Ones(points + rays + 1);
  counts.segment(points, rays).setConstant(evidence.ray_weight);
  counts(points + rays) = evidence.slope_weight;
  return counts;
}

Eigen::MatrixXd Jacobian(PrimitiveKind kind, const PrimitiveParameters& x, const Eigen::VectorXd& r,
                         const Evidence& evidence) {
  Eigen::MatrixXd jacobian(r.size(), x.size());
  for (Eigen::Index k = 0; k < x.size(); ++k) {
    PrimitiveParameters moved = x;
    moved(k) += kDerivativeStep;
    jacobian.col(k) = (Residuals(kind, moved, evidence) - r) / kDerivativeStep;
  }
  return jacobian;
}

Eigen::VectorXd WeightsOf(const Eigen::VectorXd& r, double scale) {
  return (1 + r.array().square() / (scale * scale)).square().inverse().matrix();
}

double LossOf(const Eigen::VectorXd& r, const Eigen::VectorXd& counts, double scale) {
  return (counts.array() * r.array().square() / (1 + r.array().square() / (scale * scale))).sum();
}

struct Minimum {
  PrimitiveParameters x;
  Eigen::VectorXd residuals;
};

// Levenberg-Marquardt at one scale of the loss.
class Descent {
 public:
  Descent(PrimitiveKind kind, double scale, const Evidence& evidence, const FitContext& context)
      : kind_(kind),
        scale_(scale),
        evidence_(evidence),
        counts_(CountsOf(evidence)),
        context_(context) {}

  void Run(int iterations, Minimum& at) {
    for (int k = 0; k < iterations; ++k) {
      context_.work.Poll();
      const double before = Loss(at);
      if (!Step(at) || before - Loss(at) < kMinLossDecrease * before) return;
    }
  }

 private:
  double Loss(const Minimum& at) const { return LossOf(at.residuals, counts_, scale_); }

  // Takes one damped step. False if no damping lowers the loss.
  bool Step(Minimum& at) {
    const Eigen::MatrixXd jacobian = Jacobian(kind_, at.x, at.residuals, evidence_);
    const Eigen::VectorXd weights = counts_.cwiseProduct(WeightsOf(at.residuals, scale_));
    const Eigen::MatrixXd weighted = weights.asDiagonal() * jacobian;
    const Eigen::MatrixXd information = jacobian.transpose() * weighted;
    const Eigen::VectorXd slope = weighted.transpose() * at.residuals;
    for (int attempt = 0; attempt < kMaxDampings; ++attempt, damping_ *= 10) {
      Eigen::MatrixXd damped = information;
      damped.diagonal() *= 1 + damping_;
      damped.diagonal().array() += kMinInformation;
      Minimum next{at.x - damped.ldlt().solve(slope), {}};
      if (!IsValid(kind_, next.x, context_.options)) continue;
      next.residuals = Residuals(kind_, next.x, evidence_);
      if (!(Loss(next) < Loss(at))) continue;
      at = std::move(next);
      damping_ *= 0.1;
      return true;
    }
    return false;
  }

  const PrimitiveKind kind_;
  const double scale_;
  const Evidence& evidence_;
  const Eigen::VectorXd counts_;
  const FitContext& context_;
  double damping_ = kFirstDamping;
};

double ShareWithinGates(const Eigen::VectorXd& r, std::size_t points) {
  const auto near = r.head(static_cast<Eigen::Index>(points)).array().abs() <= kDistanceGate_sigma;
  return static_cast<double>(near.count()) / static_cast<double>(points);
}

// The robust loss per point; `r` begins with the residuals of the points.
double StartLoss(const Eigen::VectorXd& r, std::size_t points) {
  const auto count = static_cast<Eigen::Index>(points);
  return LossOf(r.head(count), Eigen::VectorXd::Ones(count), kScales_sigma[1]) /
         static_cast<double>(points);
}

// Returns the start with the lowest loss after a few steps, and that loss in `min_loss`.
std::optional<Minimum> BestStart(PrimitiveKind kind, const std::vector<Solid>& known,
                                 const FitContext& c, double& min_loss) {
  const Evidence evidence = PointsAlone(OnGround(c, kStartPoints));
  std::optional<Minimum> best;
  min_loss = std::numeric_limits<double>::infinity();
  for (const PrimitiveParameters& start : StartsOf(kind, known, evidence.points)) {
    if (!IsValid(kind, start, c.options)) continue;
    Minimum trial{start, Residuals(kind, start, evidence)};
    Descent(kind, kScales_sigma.front(), evidence, c).Run(kStepsOfStart, trial);
    const double loss = StartLoss(trial.residuals, evidence.points.p_G.size());
    if (loss < min_loss) best = std::move(trial), min_loss = loss;
  }
  // measured: of 1 500 fits in simulated scenes that ended with 0.9 of the points within their
  // gates, 1 in 500 began with less than half of them.
  if (best && ShareWithinGates(best->residuals, evidence.points.p_G.size()) < kMajority) {
    return std::nullopt;
  }
  return best;
}

// The bounding sphere in the frame of the model points, about the middle of the bounds: the origin
// of a plate may be anywhere in it.
struct BoundingSphere {
  explicit BoundingSphere(const Solid& solid) {
    const Aabb bounds = TightBounds(solid.shape, Pose::Identity());
    middle = solid.X_MS * bounds.center();
    radius_m = 0.5 * bounds.diagonal().norm();
  }
  Vector3 middle = Vector3::Zero();
  double radius_m = 0;
};

// The cost of the rays that run deep in a solid, in units of the criterion.
double CostOf(const Solid& solid, const FitContext& c) {
  const Pose X_SM = solid.X_MS.inverse(Eigen::Isometry);
  const DistanceToShape distance_m(solid.shape);
  const BoundingSphere sphere(solid);
  double squares = 0;
  for (const FreeRay& ray : c.free.rays) {
    if (!MayComeNear(sphere.middle, sphere.radius_m, ray)) continue;
    const double depth = Depth_sigma(FindNearestRayPoint(distance_m, X_SM, ray).clearance_m, ray);
    squares += std::min(depth * depth, kTruncatedSquare);
  }
  return squares * c.free.weight / kPointsPerIndependentSample;
}

std::vector<std::uint32_t> InliersOf(const Solid& solid, const ModelPoints& points) {
  const Pose X_SM = solid.X_MS.inverse(Eigen::Isometry);
  const DistanceToShape distance_m(solid.shape);
  std::vector<std::uint32_t> inliers;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    if (std::abs(distance_m(X_SM * points.p[i])) <= points.gate_m[i]) inliers.push_back(i);
  }
  return inliers;
}

Evidence EvidenceOf(const FitContext& c, std::size_t max_points = kUsedPoints) {
  Evidence evidence = PointsAlone(OnGround(c, max_points));
  const auto used = static_cast<double>(evidence.points.p_G.size());
  evidence.slope_weight = used / std::max(1.0, c.IndependentSamples(c.points.size()));
  return evidence;
}

double RaysPerSample(PrimitiveKind kind) {
  return IsLying(kind) ? kRaysPerSampleLying : kPointsPerIndependentSample;
}

// Adds the rays within kMaxRayClearance_m of the solid to the evidence. The steps of the fit are
// too small to reach others.
void AddRaysNear(const Solid& solid, PrimitiveKind kind, const FitContext& c, Evidence& evidence) {
  const Pose X_SM = solid.X_MS.inverse(Eigen::Isometry);
  const Pose X_GM = evidence.points.X_MG.inverse(Eigen::Isometry);
  const DistanceToShape distance_m(solid.shape);
  const BoundingSphere sphere(solid);
  std::vector<Vector3> places;
  for (const FreeRay& ray : c.free.rays) {
    if (!MayComeNear(sphere.middle, sphere.radius_m + kMaxRayClearance_m, ray)) continue;
    const NearestRayPoint nearest = FindNearestRayPoint(distance_m, X_SM, ray);
    if (nearest.clearance_m > kMaxRayClearance_m) continue;
    FreeRay& near = evidence.rays_G.emplace_back(ResampledAround(nearest.p, ray));
    for (Vector3& p : near.p) places.emplace_back(p = X_GM * p);
  }
  evidence.places_G = PlaceLanes(places);
  const double measured = static_cast<double>(c.points.size()) * c.points.weight;
  evidence.ray_weight = kPointsPerIndependentSample / RaysPerSample(kind) * c.free.weight *
                        static_cast<double>(evidence.points.p_G.size()) / measured;
}

// True if nearly all inliers of an upright or leaning cylinder or cone lie on its lid and hardly
// any on its side.
bool IsLidAlone(const PrimitiveFit& fit, const ModelPoints& points) {
  double length_m = 0;
  if (const auto* cylinder = std::get_if<Cylinder>(&fit.solid.shape)) length_m = cylinder->length_m;
  if (const auto* cone = std::get_if<Cone>(&fit.solid.shape)) length_m = cone->length_m;
  if (length_m == 0 || IsLying(fit.kind)) return false;
  const Pose X_SM = fit.solid.X_MS.inverse(Eigen::Isometry);
  const auto below = std::ranges::count_if(fit.solid.inliers, [&](std::uint32_t i) {
    return (X_SM * points.p[i]).z() < 0.5 * length_m - points.gate_m[i];
  });
  return static_cast<double>(below) <
         (1 - kNearlyAll) * static_cast<double>(fit.solid.inliers.size());
}

void PlaceSolid(const PrimitiveParameters& x, const PointsOnGround& points, const FitContext& c,
                PrimitiveFit& fit) {
  const PlacedPrimitive placed = Place(fit.kind, x);
  fit.parameters = x;
  fit.solid.X_MS = points.X_MG * placed.X_GS;
  fit.solid.shape = placed.shape;
  fit.solid.inliers = InliersOf(fit.solid, c.points);
  SetFreeEnds(c.points, points, c.options, fit);
}

// Runs the descent at all scales from `at`, whose residuals need not be set. Empty if it leaves too
// many points off the solid.
std::optional<PrimitiveFit> Converged(PrimitiveKind kind, Minimum at, const Evidence& evidence,
                                      const FitContext& c) {
  at.residuals = Residuals(kind, at.x, evidence);
  for (double scale : kScales_sigma) {
    Descent(kind, scale, evidence, c).Run(kStepsPerScale, at);
    // measured: none of the 1 500 fits (BestStart) had less than 0.85 after the widest scale.
    if (ShareWithinGates(at.residuals, evidence.points.p_G.size()) < kMinFitInlierShare) {
      return std::nullopt;
    }
  }
  PrimitiveFit fit{.kind = kind, .parameters = {}, .solid = {}, .value = 0};
  PlaceSolid(at.x, evidence.points, c, fit);
  const auto points = static_cast<Eigen::Index>(evidence.points.p_G.size());
  const double unlikely = at.residuals.tail<1>()(0);
  const Misfit misfit = MisfitOf(Place(kind, at.x), at.residuals.head(points), evidence.points);
  fit.value = ValueOf(misfit, static_cast<int>(at.x.size()), evidence.points, c) +
              CostOf(fit.solid, c) + unlikely * unlikely;
  fit.loss = StartLoss(at.residuals, evidence.points.p_G.size());
  return fit;
}

}  // namespace

std::optional<PrimitiveFit> FitPrimitive(PrimitiveKind kind, const std::vector<Solid>& known,
                                         const FitScore& alternative, const FitContext& context) {
  if (!context.ground.known) return std::nullopt;
  double min_loss = 0;
  std::optional<Minimum> best = BestStart(kind, known, context, min_loss);
  if (!best || min_loss > kMaxStartLossRatio * alternative.loss) return std::nullopt;
  Evidence evidence = EvidenceOf(context);
  const std::optional<PrimitiveFit> fit = Converged(kind, *best, evidence, context);
  if (!fit || IsAtLimit(*fit, context.options)) return std::nullopt;
  const double cost = CostOf(fit->solid, context);
  const double min_cost = kMinRayCost * RaysPerSample(kind) / kPointsPerIndependentSample;
  if (cost < min_cost || fit->value - cost > alternative.value) return fit;
  AddRaysNear(fit->solid, kind, context, evidence);
  const std::optional<PrimitiveFit> moved =
      Converged(kind, {fit->parameters, {}}, evidence, context);
  const bool better = moved && moved->value < fit->value && !IsAtLimit(*moved, context.options);
  return better ? moved : fit;
}

void RefineOnMorePoints(const FitContext& context, PrimitiveFit& fit) {
  const bool ends_with_points =
      std::holds_alternative<Box>(fit.solid.shape) || IsLidAlone(fit, context.points);
  if (ends_with_points || context.points.size() <= kUsedPoints) return;
  Evidence evidence = EvidenceOf(context, kRefinementPoints);
  AddRaysNear(fit.solid, fit.kind, context, evidence);
  SetNoiseAcrossSurface(Place(fit.kind, fit.parameters), context.noise, evidence.points);
  Minimum at{fit.parameters, Residuals(fit.kind, fit.parameters, evidence)};
  Descent(fit.kind, kScales_sigma.back(), evidence, context).Run(kStepsPerScale, at);
  PrimitiveFit moved = fit;
  PlaceSolid(at.x, evidence.points, context, moved);
  if (!IsAtLimit(moved, context.options)) fit = std::move(moved);
}

Eigen::MatrixXd CovarianceOf(const PrimitiveFit& fit, const FitContext& c) {
  Evidence evidence = EvidenceOf(c);
  AddRaysNear(fit.solid, fit.kind, c, evidence);
  const Eigen::VectorXd r = Residuals(fit.kind, fit.parameters, evidence);
  const Eigen::VectorXd weight =
      CountsOf(evidence).cwiseProduct(WeightsOf(r, kScales_sigma.back()));
  const Eigen::MatrixXd jacobian = Jacobian(fit.kind, fit.parameters, r, evidence);
  Eigen::MatrixXd gradients = weight.asDiagonal() * jacobian;
  Eigen::MatrixXd information = jacobian.transpose() * gradients;
  information.diagonal().array() += kMinInformation;
  const Eigen::MatrixXd inverse = information.inverse();
  // The information counts the points used as if they were independent.
  const PointsOnGround& points = evidence.points;
  const auto used = static_cast<Eigen::Index>(points.p_G.size());
  const double each_counts =
      static_cast<double>(used) / std::max(1.0, c.IndependentSamples(c.points.size()));
  const double chi_square =
      weight.head(used).dot(r.head(used).cwiseAbs2()) / static_cast<double>(used);
  Eigen::MatrixXd warped = gradients.topRows(used);
  for (Eigen::Index i = 0; i < used; ++i) {
    warped.row(i) *= c.noise.WarpSigma_m() / points.sigma_m[static_cast<std::size_t>(i)];
  }
  return each_counts * std::max(kVariance, chi_square) * inverse +
         inverse * WarpOf(points.p_G, warped) * inverse;
}

std::vector<double> CoefficientSigmas(const PrimitiveFit& fit, const Eigen::MatrixXd& covariance,
                                      const FitContext& c) {
  const Pose X_MG = OnGround(c).X_MG;
  const Pose X_MS = X_MG * Place(fit.kind, fit.parameters).X_GS;
  const auto coefficients = [&](const Eigen::VectorXd& step) {
    const PlacedPrimitive solid = Place(fit.kind, fit.parameters + step);
    std::vector<double> values = Coefficients(solid.shape, X_MG * solid.X_GS);
    if (std::holds_alternative<Cylinder>(solid.shape)) {
      // Any point of a line represents it, so its component along the line has no error. An
      // unconstrained end of the cylinder would otherwise move it.
      Eigen::Map<Vector3> point(values.data());
      const Vector3 axis = X_MS.linear().col(2);
      point -= axis.dot(point - X_MS.translation()) * axis;
    }
    return values;
  };
  std::vector<double> sigma = PropagatedSigmas(coefficients, covariance);
  // Up is known to kUpSigma_rad, and the axis of an upright or lying solid is known no better
  // across itself. Along itself a unit vector has no error.
  constexpr std::size_t kAxis = Vector3::SizeAtCompileTime;  // the axis comes after a point
  if (fit.kind != PrimitiveKind::kBall && sigma.size() > kAxis + 3) {
    const std::vector<double> values = coefficients(Eigen::VectorXd::Zero(covariance.rows()));
    for (std::size_t k = kAxis; k < kAxis + 3; ++k) {
      const double across = std::sqrt(std::max(0.0, 1 - values[k] * values[k]));
      sigma[k] = std::hypot(sigma[k], across * kUpSigma_rad);
    }
  }
  return sigma;
}

FitScore FitScoreOf(const std::vector<Solid>& solids, int parameters, const FitContext& c) {
  const PointsOnGround points = OnGround(c);
  const auto count = static_cast<Eigen::Index>(points.p_G.size());
  Misfit nearest{Eigen::VectorXd::Constant(count, kNoSolidResidual_sigma),
                 Eigen::VectorXd::Zero(count)};
  double cost = 0;
  for (const Solid& solid : solids) {
    const Pose X_SG = solid.X_MS.inverse(Eigen::Isometry) * points.X_MG;
    const DistanceToShape distance_m(solid.shape);
    for (Eigen::Index i = 0; i < count; ++i) {
      const auto at = static_cast<std::size_t>(i);
      const Vector3& p = points.p_G[at];
      const double residual = distance_m(X_SG * p) / points.sigma_m[at];
      if (std::abs(residual) >= std::abs(nearest.residuals(i))) continue;
      nearest.residuals(i) = residual;
      nearest.along_ray(i) = DerivativeAlongRay(solid.shape, X_SG, p, points.viewpoint_G);
    }
    cost += CostOf(solid, c);
  }
  return {.value = ValueOf(nearest, parameters, points, c) + cost,
          .loss = StartLoss(nearest.residuals, points.p_G.size())};
}

}  // namespace cwm::perception
