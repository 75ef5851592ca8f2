#include "perception/fit/shape_fit.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <type_traits>

#include "perception/cloud/tolerances.h"

namespace cwm::perception {
namespace {

// chosen: points of a rough and of a final fit. Neighbours are correlated, so thinning loses almost
// nothing.
constexpr std::size_t kRoughPoints = 250;
constexpr std::size_t kFinalPoints = 600;
// chosen: rough fits alternate with the selection of inliers, so none needs to converge.
constexpr int kRoughIterations = 8;
// chosen: the gate's scale at the first inlier selection of cones. The paper asks for a stricter
// threshold and does not print it; 1.8 sigma keeps 93 % of the inliers.
constexpr double kStrictGate = 0.6;
// chosen: cones with half angles beyond 45 degrees cannot be distinguished from bumps.
constexpr double kSteepestCone = 1;
// chosen: the least share of points whose rays meet the surface well. With fewer, the residual is
// orthogonal.
constexpr double kMinAlongRays = 0.3;

bool WithinLimits(const PlaneModel&, const ModelerOptions&) { return true; }

template <class Curved>
bool RadiusWithinLimits(const Curved& model, const ModelerOptions& options) {
  return model.radius_m >= options.min_radius_m && model.radius_m <= options.max_radius_m;
}
bool WithinLimits(const SphereModel& m, const ModelerOptions& o) {
  return RadiusWithinLimits(m, o);
}
bool WithinLimits(const CylinderModel& m, const ModelerOptions& o) {
  return RadiusWithinLimits(m, o);
}
bool WithinLimits(const ConeModel& m, const ModelerOptions& o) {
  return RadiusWithinLimits(m, o) && std::abs(m.slope) <= kSteepestCone;
}

Vector3 Centroid(const ModelPoints& points, const std::vector<std::uint32_t>& inliers) {
  Vector3 sum = Vector3::Zero();
  for (std::uint32_t i : inliers) sum += points.p[i];
  return sum / static_cast<double>(inliers.size());
}

template <ShapeModel M>
std::vector<std::uint32_t> ConnectedInliers(const M& model, const FitContext& c,
                                            const std::vector<char>& available, double gate_scale) {
  return c.connectivity.LargestComponent(
      FindInliers(model, c.points, c.octree, available, gate_scale));
}

bool Enough(const std::vector<std::uint32_t>& inliers, const FitContext& c) {
  return static_cast<double>(inliers.size()) * c.points.weight >= c.options.min_inliers;
}

template <ShapeModel M>
double FirstGate(const M&) {
  return 1;
}
// A cone that starts from a cylinder is refined already.
double FirstGate(const ConeModel& cone) { return cone.slope == 0 ? 1 : kStrictGate; }

template <ShapeModel M>
std::optional<ShapeFit> FitOne(M model, AxisFreedom axis, const FitContext& c,
                               const std::vector<char>& available) {
  const double first_gate = FirstGate(model);
  const RefineOptions options{.residual = Residual::kOrthogonal,
                              .axis = axis,
                              .max_iterations = kRoughIterations,
                              .noise = c.noise};
  std::vector<std::uint32_t> inliers;
  for (double gate_scale : {first_gate, 1.0, 1.0}) {
    c.work.Poll();
    inliers = ConnectedInliers(model, c, available, gate_scale);
    if (!Enough(inliers, c)) return std::nullopt;
    const auto refined = Refine(model.Centred(Centroid(c.points, inliers)), c.points,
                                Subsampled(inliers, kRoughPoints), options);
    if (!refined || !WithinLimits(refined->model, c.options)) return std::nullopt;
    model = refined->model;
  }
  inliers = ConnectedInliers(model, c, available, 1);
  if (!Enough(inliers, c)) return std::nullopt;
  ShapeFit fit;
  fit.model = model.Centred(Centroid(c.points, inliers));
  fit.axis = axis;
  fit.inliers = std::move(inliers);
  return fit;
}

const Vector3* DirectionOf(const PlaneModel& m) { return &m.normal; }
const Vector3* DirectionOf(const SphereModel&) { return nullptr; }
const Vector3* DirectionOf(const CylinderModel& m) { return &m.axis; }
const Vector3* DirectionOf(const ConeModel& m) { return &m.axis; }

PlaneModel WithDirection(PlaneModel m, const Vector3& d) {
  m.normal = d;
  return m;
}
SphereModel WithDirection(SphereModel m, const Vector3&) { return m; }
template <class Axial>
Axial WithDirection(Axial m, const Vector3& d) {
  m.axis = d;
  return m;
}

PlaneModel Canonical(const PlaneModel& m, const Vector3&) { return m; }
SphereModel Canonical(const SphereModel& m, const Vector3&) { return m; }
CylinderModel Canonical(CylinderModel m, const Vector3& up) {
  m.axis = CanonicalAxis(m.axis, up);
  return m;
}
ConeModel Canonical(ConeModel m, const Vector3& up) {
  const Vector3 axis = CanonicalAxis(m.axis, up);
  if (axis.dot(m.axis) < 0) m.slope = -m.slope;  // the same surface from its other end
  m.axis = axis;
  return m;
}

// A last refinement, with the options it was made with.
template <ShapeModel M>
struct FinalFit {
  Refined<M> refined;
  RefineOptions options;
};

// Refines the residual along the rays, or the orthogonal one if the surface is seen so flat that
// few rays meet it well.
template <ShapeModel M>
std::optional<FinalFit<M>> RefineFinally(const M& start, const FitContext& c,
                                         const std::vector<std::uint32_t>& inliers,
                                         AxisFreedom axis) {
  const std::vector<std::uint32_t> used = Subsampled(inliers, kFinalPoints);
  RefineOptions options{.residual = Residual::kAlongRay, .axis = axis, .noise = c.noise};
  std::optional<Refined<M>> refined = Refine(start, c.points, used, options);
  if (!refined || refined->points_used < kMinAlongRays * static_cast<double>(used.size())) {
    options.residual = Residual::kOrthogonal;
    refined = Refine(start, c.points, used, options);
  }
  if (!refined || !WithinLimits(refined->model, c.options)) return std::nullopt;
  return FinalFit<M>{*refined, options};
}

// Returns the refinement with the direction held to up, if it is near up and the criterion prefers
// that.
template <ShapeModel M>
std::optional<FinalFit<M>> SnapToUp(const M& free, const FitContext& c,
                                    const std::vector<std::uint32_t>& inliers) {
  const Vector3* direction = DirectionOf(free);
  if (direction == nullptr || std::abs(direction->dot(c.ground.up)) < std::cos(kUprightWithin_rad))
    return std::nullopt;
  const Vector3 snapped = direction->dot(c.ground.up) > 0 ? c.ground.up : Vector3(-c.ground.up);
  auto held = RefineFinally(WithDirection(free, snapped), c, inliers, AxisFreedom::kHeld);
  if (!held) return std::nullopt;
  const double loss = EvaluateCriterion(held->refined.model, AxisFreedom::kHeld, c, inliers).value -
                      EvaluateCriterion(free, AxisFreedom::kFree, c, inliers).value;
  return loss < 0 ? held : std::nullopt;
}

// The covariance of the parameters. Independent noise falls with the number of samples; the slow
// warp, which neighbours share, does not.
template <ShapeModel M>
Eigen::MatrixXd CovarianceOf(const FinalFit<M>& fit, const FitContext& c,
                             const std::vector<std::uint32_t>& inliers) {
  using Square = typename Refined<M>::Information;
  const std::vector<std::uint32_t> used = Subsampled(inliers, kFinalPoints);
  const Square inverse = fit.refined.information.inverse();
  const Square warp = WarpOfGradient(fit.refined.model, c.points, used, fit.options);
  // The information counts the points used as if they were independent.
  const double each_counts =
      static_cast<double>(used.size()) / std::max(c.IndependentSamples(inliers.size()), 1.0);
  Square covariance =
      each_counts * std::max(1.0, fit.refined.chi_square) * inverse + inverse * warp * inverse;
  if constexpr (DirectedModel<M>) {
    if (fit.options.axis == AxisFreedom::kHeld) {
      covariance.template middleRows<2>(M::kFirstTilt).setZero();
      covariance.template middleCols<2>(M::kFirstTilt).setZero();
      covariance.diagonal()
          .template segment<2>(M::kFirstTilt)
          .setConstant(kUpSigma_rad * kUpSigma_rad);
    }
  }
  return covariance;
}

template <ShapeModel M>
std::optional<ShapeFit> FinishOne(const M& start, const ShapeFit& fit, const FitContext& c,
                                  const std::vector<char>& available) {
  c.work.Poll();
  ShapeFit out;
  std::optional<FinalFit<M>> best =
      RefineFinally(Canonical(start, c.ground.up), c, fit.inliers, fit.axis);
  if (!best) return std::nullopt;
  if (fit.axis == AxisFreedom::kFree) {
    if (auto snapped = SnapToUp(best->refined.model, c, fit.inliers)) best = snapped;
  }
  out.axis = best->options.axis;
  out.model = best->refined.model;
  out.inliers = ConnectedInliers(best->refined.model, c, available, 1);
  if (!Enough(out.inliers, c)) return std::nullopt;
  out.covariance = CovarianceOf(*best, c, fit.inliers);
  return out;
}

template <ShapeModel M>
double TruncatedSquare(const M& model, const ModelPoints& points, std::uint32_t i) {
  const double ratio = model.Distance_m(points.p[i]) / points.sigma_m[i];
  if (!(ratio * ratio < kTruncatedSquare)) return kTruncatedSquare;
  const double agreement = model.FacingSign() * model.Normal(points.p[i]).dot(points.n[i]);
  return agreement < points.min_cos[i] ? kTruncatedSquare : ratio * ratio;
}

double Count(const std::vector<std::uint32_t>& listed) {
  return static_cast<double>(listed.size());
}

}  // namespace

Vector3 CanonicalAxis(const Vector3& axis, const Vector3& up) {
  double sign = axis.dot(up);
  if (std::abs(sign) < kDegree) sign = axis.x();
  if (std::abs(sign) < kDegree) sign = axis.y();
  return sign < 0 ? Vector3(-axis) : axis;
}

std::vector<std::uint32_t> ConnectedInliers(const AnyModel& model, const FitContext& context,
                                            const std::vector<char>& available) {
  return std::visit([&](const auto& m) { return ConnectedInliers(m, context, available, 1); },
                    model);
}

int DegreesOfFreedom(const AnyModel& model, AxisFreedom axis) {
  return ParameterCount(model) - (axis == AxisFreedom::kHeld ? 2 : 0);
}

std::optional<ShapeFit> FitShape(const AnyModel& start, AxisFreedom axis, const FitContext& context,
                                 const std::vector<char>& available) {
  return std::visit([&](const auto& m) { return FitOne(m, axis, context, available); }, start);
}

std::optional<ShapeFit> FinishFit(const ShapeFit& fit, const FitContext& context,
                                  const std::vector<char>& available) {
  return std::visit([&](const auto& m) { return FinishOne(m, fit, context, available); },
                    fit.model);
}

Criterion CriterionOf(double mean_square, std::size_t count, int parameters,
                      const FitContext& context) {
  if (count == 0) return {};
  const double samples = std::max(2.0, context.IndependentSamples(count));
  return {.value = samples * mean_square + parameters * std::log(samples),
          .rms_sigma = std::sqrt(mean_square)};
}

Criterion EvaluateCriterion(const AnyModel& model, AxisFreedom axis, const FitContext& context,
                            const std::vector<std::uint32_t>& listed) {
  const double squares = std::visit(
      [&](const auto& m) {
        double sum = 0;
        for (std::uint32_t i : listed) sum += TruncatedSquare(m, context.points, i);
        return sum;
      },
      model);
  return CriterionOf(squares / Count(listed), listed.size(), DegreesOfFreedom(model, axis),
                     context);
}

Criterion EvaluateCriterion(const std::vector<PlaneModel>& planes, const FitContext& context,
                            const std::vector<std::uint32_t>& listed) {
  double squares = 0;
  for (std::uint32_t i : listed) {
    double min_square = kTruncatedSquare;
    for (const PlaneModel& plane : planes) {
      min_square = std::min(min_square, TruncatedSquare(plane, context.points, i));
    }
    squares += min_square;
  }
  return CriterionOf(squares / Count(listed), listed.size(),
                     PlaneModel::kParameterCount * static_cast<int>(planes.size()), context);
}

}  // namespace cwm::perception
