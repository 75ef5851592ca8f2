#include "perception/model/shape_fit.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <type_traits>

namespace cwm::perception {
namespace {

// Points of a fit: correlated neighbours add little, so thinning costs next to nothing.
constexpr std::size_t kRoughPoints = 250;
constexpr std::size_t kFinalPoints = 600;
// Chosen: rough fits alternate with the selection of inliers, so that none needs to converge; final
// ones end by convergence, and this only bounds their work.
constexpr int kRoughIterations = 5;
constexpr int kFinalIterations = 20;
// Of the first inlier selection of cones: the paper asks for a stricter threshold first and does
// not print it. Chosen: 1.8 sigma, which keeps 93 % of the inliers.
constexpr double kStrictGate = 0.6;
constexpr double kSteepestSlope = 1;  // half angles beyond 45 degrees are not told from bumps
// The noise of a face of 60 points turns its normal by 3 to 4 degrees.
const double kSnapAngle_cos = std::cos(3 * std::numbers::pi / 180);
constexpr double kTruncation = 9;  // squares beyond 3 sigma

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
  return RadiusWithinLimits(m, o) && std::abs(m.slope) <= kSteepestSlope;
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
std::optional<ShapeFit> FitOne(M model, AxisFreedom axis, const FitContext& c,
                               const std::vector<char>& available) {
  constexpr double kFirstGate = std::is_same_v<M, ConeModel> ? kStrictGate : 1;
  const RefineOptions options{.residual = Residual::kOrthogonal,
                              .axis = axis,
                              .max_iterations = kRoughIterations,
                              .noise = c.noise};
  std::vector<std::uint32_t> inliers;
  for (double gate_scale : {kFirstGate, 1.0, 1.0}) {
    c.work.Poll();
    inliers = ConnectedInliers(model, c, available, gate_scale);
    if (!Enough(inliers, c)) return std::nullopt;
    const auto refined = Refine(model.Centred(Centroid(c.points, inliers)), c.points,
                                Thinned(inliers, kRoughPoints), options);
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
  if (axis.dot(m.axis) < 0) m.slope = -m.slope;  // the same surface, seen from its other end
  m.axis = axis;
  return m;
}

template <ShapeModel M>
std::optional<Refined<M>> RefineFinally(const M& start, const FitContext& c,
                                        const std::vector<std::uint32_t>& inliers,
                                        AxisFreedom axis) {
  return Refine(start, c.points, Thinned(inliers, kFinalPoints),
                {.residual = Residual::kAlongRay,
                 .axis = axis,
                 .max_iterations = kFinalIterations,
                 .noise = c.noise});
}

// The refinement with the direction held to up, where it is near and the criterion prefers it.
template <ShapeModel M>
std::optional<Refined<M>> SnapToUp(const Refined<M>& free, const FitContext& c,
                                   const std::vector<std::uint32_t>& inliers) {
  const Vector3* direction = DirectionOf(free.model);
  if (direction == nullptr || std::abs(direction->dot(c.up)) < kSnapAngle_cos) return std::nullopt;
  const Vector3 snapped = direction->dot(c.up) > 0 ? c.up : Vector3(-c.up);
  auto held = RefineFinally(WithDirection(free.model, snapped), c, inliers, AxisFreedom::kHeld);
  if (!held || !WithinLimits(held->model, c.options)) return std::nullopt;
  const double loss = EvaluateCriterion(held->model, AxisFreedom::kHeld, c, inliers).value -
                      EvaluateCriterion(free.model, AxisFreedom::kFree, c, inliers).value;
  return loss < 0 ? held : std::nullopt;
}

template <ShapeModel M>
std::optional<ShapeFit> FinishOne(const M& start, const ShapeFit& fit, const FitContext& c,
                                  const std::vector<char>& available) {
  c.work.Poll();
  ShapeFit out;
  out.axis = fit.axis;
  std::optional<Refined<M>> best = RefineFinally(Canonical(start, c.up), c, fit.inliers, fit.axis);
  if (!best || !WithinLimits(best->model, c.options)) return std::nullopt;
  if (fit.axis == AxisFreedom::kFree) {
    if (std::optional<Refined<M>> snapped = SnapToUp(*best, c, fit.inliers)) {
      best = snapped;
      out.axis = AxisFreedom::kHeld;
    }
  }
  out.model = best->model;
  out.inliers = ConnectedInliers(best->model, c, available, 1);
  if (!Enough(out.inliers, c)) return std::nullopt;
  // The information is of the points used, as if they were independent.
  const double all = c.IndependentSamples(fit.inliers.size());
  const double scale = best->points_used / std::max(all, 1.0) * std::max(1.0, best->chi_square);
  out.covariance = scale * best->information.inverse();
  if (M::kFirstTilt >= 0 && out.axis == AxisFreedom::kHeld) {
    out.covariance.middleRows(std::max(M::kFirstTilt, 0), 2).setZero();
    out.covariance.middleCols(std::max(M::kFirstTilt, 0), 2).setZero();
  }
  return out;
}

template <ShapeModel M>
double TruncatedSquare(const M& model, const ModelPoints& points, std::uint32_t i) {
  const double ratio = model.Distance_m(points.p[i]) / points.sigma_m[i];
  if (!(ratio * ratio < kTruncation)) return kTruncation;
  const double agreement = model.FacingSign() * model.Normal(points.p[i]).dot(points.n[i]);
  return agreement < points.min_cos[i] ? kTruncation : ratio * ratio;
}

Criterion MakeCriterion(double squares, std::size_t count, int parameters, const FitContext& c) {
  if (count == 0) return {};
  const double mean = squares / static_cast<double>(count);
  const double samples = std::max(2.0, c.IndependentSamples(count));
  return {.value = samples * mean + parameters * std::log(samples), .rms_sigma = std::sqrt(mean)};
}

}  // namespace

Vector3 CanonicalAxis(const Vector3& axis, const Vector3& up) {
  constexpr double kLevel = 0.0175;  // 1 degree
  double sign = axis.dot(up);
  if (std::abs(sign) < kLevel) sign = axis.x();
  if (std::abs(sign) < kLevel) sign = axis.y();
  return sign < 0 ? Vector3(-axis) : axis;
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

Criterion EvaluateCriterion(const AnyModel& model, AxisFreedom axis, const FitContext& context,
                            const std::vector<std::uint32_t>& listed) {
  const double squares = std::visit(
      [&](const auto& m) {
        double sum = 0;
        for (std::uint32_t i : listed) sum += TruncatedSquare(m, context.points, i);
        return sum;
      },
      model);
  return MakeCriterion(squares, listed.size(), DegreesOfFreedom(model, axis), context);
}

Criterion EvaluateCriterion(const std::vector<PlaneModel>& planes, const FitContext& context,
                            const std::vector<std::uint32_t>& listed) {
  double squares = 0;
  for (std::uint32_t i : listed) {
    double least = kTruncation;
    for (const PlaneModel& plane : planes) {
      least = std::min(least, TruncatedSquare(plane, context.points, i));
    }
    squares += least;
  }
  return MakeCriterion(squares, listed.size(),
                       PlaneModel::kParameterCount * static_cast<int>(planes.size()), context);
}

}  // namespace cwm::perception
