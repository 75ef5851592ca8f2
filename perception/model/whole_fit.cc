#include "perception/model/whole_fit.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "collision/geometry/coefficients.h"
#include "collision/geometry/distance_to_shape.h"
#include "perception/model/whole_starts.h"

namespace cwm::perception {
namespace {

// Neighbouring residuals are correlated: 240 points of 3 000 measured ones lose nothing.
constexpr std::size_t kUsedPoints = 240;
constexpr std::size_t kStartPoints = 80;  // to find the best start
// Of the loss, in standard deviations: wide, so that far starts are drawn in, then as narrow as
// keeps 95 % of the efficiency.
constexpr std::array<double, 3> kScales_sigma = {10, 4, 2.5};
constexpr int kFirstIterations = 3;  // of every start
constexpr int kIterations = 8;       // per scale, of the best
constexpr double kHopeless = 3;      // times a rival's loss, at the best start
constexpr int kAttempts = 4;         // to find a damping that helps
constexpr double kFirstDamping = 1e-3;
constexpr double kConverged = 1e-3;         // relative decrease of the loss
constexpr double kLeastInformation = 1e-9;  // of a parameter that no point tells
constexpr double kStep = 1e-6;              // metres or radians, of numerical derivatives
constexpr double kFarAway_sigma = 1e6;      // from no solid at all
constexpr double kSteepestSlope = 0.36;     // 20 degrees: wider cups are bowls

PointsOnGround OnGround(const FitContext& c, std::size_t most = kUsedPoints) {
  PointsOnGround out;
  out.X_MG.linear() = BasisFromZ(c.ground.up);
  out.X_MG.translation() = -c.ground.Height_m(Vector3::Zero()) * c.ground.up;
  const Pose X_GM = out.X_MG.inverse(Eigen::Isometry);
  const std::size_t stride = (c.points.size() + most - 1) / most;
  for (std::size_t i = 0; i < c.points.size(); i += stride) {
    out.p_G.push_back(X_GM * c.points.p[i]);
    out.sigma_m.push_back(c.points.sigma_m[i]);
  }
  return out;
}

// In standard deviations.
Eigen::VectorXd Residuals(WholeKind kind, const WholeParameters& x, const PointsOnGround& points) {
  const WholeSolid solid = Place(kind, x);
  const Pose X_SG = solid.X_GS.inverse(Eigen::Isometry);
  const DistanceToShape distance_m(solid.shape);
  Eigen::VectorXd r(static_cast<Eigen::Index>(points.p_G.size()));
  for (Eigen::Index i = 0; i < r.size(); ++i) {
    const auto at = static_cast<std::size_t>(i);
    r(i) = distance_m(X_SG * points.p_G[at]) / points.sigma_m[at];
  }
  return r;
}

Eigen::MatrixXd Jacobian(WholeKind kind, const WholeParameters& x, const Eigen::VectorXd& r,
                         const PointsOnGround& points) {
  Eigen::MatrixXd jacobian(r.size(), x.size());
  for (Eigen::Index k = 0; k < x.size(); ++k) {
    WholeParameters moved = x;
    moved(k) += kStep;
    jacobian.col(k) = (Residuals(kind, moved, points) - r) / kStep;
  }
  return jacobian;
}

Eigen::VectorXd WeightsOf(const Eigen::VectorXd& r, double scale) {
  return (1 + r.array().square() / (scale * scale)).square().inverse().matrix();
}

double LossOf(const Eigen::VectorXd& r, double scale) {
  return (r.array().square() / (1 + r.array().square() / (scale * scale))).sum();
}

bool IsWithin(double radius_m, const ModelerOptions& options) {
  return radius_m >= options.min_radius_m && radius_m <= options.max_radius_m;
}

bool IsValid(WholeKind kind, const WholeParameters& x, const ModelerOptions& options) {
  if (!x.allFinite() || std::abs(SlopeOf(kind, x)) > kSteepestSlope) return false;
  const Shape shape = Place(kind, x).shape;
  if (const auto* sphere = std::get_if<Sphere>(&shape)) return IsWithin(sphere->radius_m, options);
  if (const auto* cylinder = std::get_if<Cylinder>(&shape)) {
    return IsWithin(cylinder->radius_m, options) && cylinder->length_m >= options.min_radius_m;
  }
  if (const auto* cone = std::get_if<Cone>(&shape)) {
    return IsWithin(cone->radius_bottom_m, options) && IsWithin(cone->radius_top_m, options) &&
           cone->length_m >= options.min_radius_m;
  }
  return std::get<Box>(shape).size_m.minCoeff() >= 2 * options.min_radius_m;
}

struct Minimum {
  WholeParameters x;
  Eigen::VectorXd residuals;
};

// Levenberg-Marquardt at one scale of the loss.
class Descent {
 public:
  Descent(WholeKind kind, double scale, const PointsOnGround& points, const FitContext& context)
      : kind_(kind), scale_(scale), points_(points), context_(context) {}

  void Run(int iterations, Minimum& at) {
    for (int k = 0; k < iterations; ++k) {
      context_.work.Poll();
      const double before = LossOf(at.residuals, scale_);
      if (!Step(at) || before - LossOf(at.residuals, scale_) < kConverged * before) return;
    }
  }

 private:
  // False when no damping helps.
  bool Step(Minimum& at) {
    const Eigen::MatrixXd jacobian = Jacobian(kind_, at.x, at.residuals, points_);
    const Eigen::MatrixXd weighted = WeightsOf(at.residuals, scale_).asDiagonal() * jacobian;
    const Eigen::MatrixXd information = jacobian.transpose() * weighted;
    const Eigen::VectorXd slope = weighted.transpose() * at.residuals;
    for (int attempt = 0; attempt < kAttempts; ++attempt, damping_ *= 10) {
      Eigen::MatrixXd damped = information;
      damped.diagonal() *= 1 + damping_;
      damped.diagonal().array() += kLeastInformation;
      Minimum next{at.x - damped.ldlt().solve(slope), {}};
      if (!IsValid(kind_, next.x, context_.options)) continue;
      next.residuals = Residuals(kind_, next.x, points_);
      if (!(LossOf(next.residuals, scale_) < LossOf(at.residuals, scale_))) continue;
      at = std::move(next);
      damping_ *= 0.1;
      return true;
    }
    return false;
  }

  const WholeKind kind_;
  const double scale_;
  const PointsOnGround& points_;
  const FitContext& context_;
  double damping_ = kFirstDamping;
};

double StartLoss(const Eigen::VectorXd& r) {
  return LossOf(r, kScales_sigma[1]) / static_cast<double>(r.size());
}

// The start that has come closest after a few steps.
std::optional<Minimum> BestStart(WholeKind kind, const std::vector<Solid>& known,
                                 const FitContext& c) {
  const PointsOnGround points = OnGround(c, kStartPoints);
  std::optional<Minimum> best;
  double least = std::numeric_limits<double>::infinity();
  for (const WholeParameters& start : StartsOf(kind, known, points)) {
    if (!IsValid(kind, start, c.options)) continue;
    Minimum trial{start, Residuals(kind, start, points)};
    Descent(kind, kScales_sigma.front(), points, c).Run(kFirstIterations, trial);
    const double loss = StartLoss(trial.residuals);
    if (loss < least) best = std::move(trial), least = loss;
  }
  return best;
}

double ValueOf(const Eigen::VectorXd& r, int parameters, const FitContext& c) {
  const double mean_square = r.array().square().min(kTruncatedSquare).mean();
  return CriterionOf(mean_square, c.points.size(), parameters, c).value;
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

}  // namespace

std::optional<WholeFit> FitWhole(WholeKind kind, const std::vector<Solid>& known, double rival_loss,
                                 const FitContext& context) {
  if (!context.ground.known) return std::nullopt;
  std::optional<Minimum> best = BestStart(kind, known, context);
  if (!best || StartLoss(best->residuals) > kHopeless * rival_loss) return std::nullopt;
  const PointsOnGround points = OnGround(context);
  best->residuals = Residuals(kind, best->x, points);
  for (double scale : kScales_sigma) Descent(kind, scale, points, context).Run(kIterations, *best);
  WholeFit fit{.kind = kind, .parameters = best->x, .solid = {}, .value = 0};
  fit.value = ValueOf(best->residuals, static_cast<int>(best->x.size()), context);
  const WholeSolid placed = Place(kind, best->x);
  fit.solid.X_MS = points.X_MG * placed.X_GS;
  fit.solid.shape = placed.shape;
  fit.solid.inliers = InliersOf(fit.solid, context.points);
  return fit;
}

Eigen::MatrixXd CovarianceOf(const WholeFit& fit, const FitContext& c) {
  const PointsOnGround points = OnGround(c);
  const Eigen::VectorXd r = Residuals(fit.kind, fit.parameters, points);
  const Eigen::VectorXd weight = WeightsOf(r, kScales_sigma.back());
  const Eigen::MatrixXd jacobian = Jacobian(fit.kind, fit.parameters, r, points);
  Eigen::MatrixXd gradients = weight.asDiagonal() * jacobian;
  Eigen::MatrixXd information = jacobian.transpose() * gradients;
  information.diagonal().array() += kLeastInformation;
  const Eigen::MatrixXd inverse = information.inverse();
  // The information is of the points used, as if they were independent.
  const double each_counts =
      static_cast<double>(r.size()) / std::max(1.0, c.IndependentSamples(c.points.size()));
  const double chi_square = weight.dot(r.cwiseAbs2()) / static_cast<double>(r.size());
  for (Eigen::Index i = 0; i < r.size(); ++i) {
    gradients.row(i) *= c.noise.WarpSigma_m() / points.sigma_m[static_cast<std::size_t>(i)];
  }
  return each_counts * std::max(1.0, chi_square) * inverse +
         inverse * WarpOf(points.p_G, gradients) * inverse;
}

std::vector<double> CoefficientSigmas(const WholeFit& fit, const Eigen::MatrixXd& covariance,
                                      const FitContext& c) {
  const Pose X_MG = OnGround(c).X_MG;
  const auto coefficients = [&](const Eigen::VectorXd& step) {
    const WholeSolid solid = Place(fit.kind, fit.parameters + step);
    return Coefficients(solid.shape, X_MG * solid.X_GS);
  };
  std::vector<double> sigma = PropagatedSigmas(coefficients, covariance);
  // Up is known to kUpSigma_rad; the axis of a solid that stands or lies is no better known.
  constexpr std::size_t kAxis = 3;
  if (fit.kind != WholeKind::kBall && sigma.size() > kAxis + 3) {
    for (std::size_t k = kAxis; k < kAxis + 3; ++k) sigma[k] = std::hypot(sigma[k], kUpSigma_rad);
  }
  return sigma;
}

Account AccountOf(const std::vector<Solid>& solids, int parameters, const FitContext& c) {
  const PointsOnGround points = OnGround(c);
  Eigen::VectorXd nearest =
      Eigen::VectorXd::Constant(static_cast<Eigen::Index>(points.p_G.size()), kFarAway_sigma);
  for (const Solid& solid : solids) {
    const Pose X_SG = solid.X_MS.inverse(Eigen::Isometry) * points.X_MG;
    const DistanceToShape distance_m(solid.shape);
    for (Eigen::Index i = 0; i < nearest.size(); ++i) {
      const auto at = static_cast<std::size_t>(i);
      const double in_sigma = std::abs(distance_m(X_SG * points.p_G[at])) / points.sigma_m[at];
      nearest(i) = std::min(nearest(i), in_sigma);
    }
  }
  return {.value = ValueOf(nearest, parameters, c), .loss = StartLoss(nearest)};
}

}  // namespace cwm::perception
