#include "perception/fit/refine.h"
#include "perception/cloud/decompositions.h"

#include <cmath>
#include <numbers>
#include <vector>

namespace cwm::perception {
namespace {

// derived: 95 % efficient for Gaussian residuals.
constexpr double kCauchy_sigma = 2.4;
// chosen: 70 degrees of incidence; points seen at a flatter angle are left out.
const double kGrazing_cos = std::cos(70 * std::numbers::pi / 180);
// chosen: the refinement ends when a step lowers the loss by a smaller share than this, or when the
// damping leaves a smaller share of a step.
constexpr double kMinDecrease = 1e-6;
// chosen: the least pivot of the information matrix scaled to unit diagonal; smaller ones are
// rounding errors.
constexpr double kMinPivot = 1e-9;

// A point, the ray that measured it, and one standard deviation of its residual.
struct Observation {
  Vector3 p;
  Vector3 ray;  // unit, from the sensor
  double sigma_m = 0;
};

struct Meeting {
  double ahead_m = 0;  // from the measured point along the ray to the surface
  Vector3 at = Vector3::Zero();
  double incline = 0;  // surface normal . ray
  bool found = false;
};

// Intersects the ray with the surface by Newton's method on the distance function, from the
// measured point.
template <ShapeModel M>
Meeting MeetSurface(const M& model, const Observation& o) {
  Meeting meeting{.at = o.p};
  for (int step = 0; step < 6; ++step) {
    const double distance_m = model.Distance_m(meeting.at);
    meeting.incline = model.Normal(meeting.at).dot(o.ray);
    if (std::abs(meeting.incline) < 0.5 * kGrazing_cos) return meeting;
    const double advance_m = -distance_m / meeting.incline;
    meeting.ahead_m += advance_m;
    meeting.at += advance_m * o.ray;
    if (std::abs(advance_m) < 1e-6) {
      meeting.found = true;
      return meeting;
    }
  }
  return meeting;
}

template <ShapeModel M>
struct Linearised {
  double residual = 0;  // in standard deviations
  typename M::Parameters gradient;
};

template <ShapeModel M>
Linearised<M> Linearise(const M& model, const Observation& o, Residual kind) {
  if (kind == Residual::kAlongRay) {
    const Meeting meeting = MeetSurface(model, o);
    if (meeting.found) {
      const double scale = -1 / (meeting.incline * o.sigma_m);
      return {meeting.ahead_m / o.sigma_m, scale * model.Gradient(meeting.at)};
    }
  }
  // The ray misses the surface, so the orthogonal distance of the point is used.
  return {model.Distance_m(o.p) / o.sigma_m, model.Gradient(o.p) / o.sigma_m};
}

template <ShapeModel M>
std::vector<Observation> Observe(const M& model, const ModelPoints& points,
                                 std::span<const std::uint32_t> inliers,
                                 const RefineOptions& options) {
  std::vector<Observation> out;
  out.reserve(inliers.size());
  for (std::uint32_t i : inliers) {
    const Vector3 from_sensor = points.p[i] - points.viewpoint;
    const double range_m = from_sensor.norm();
    Observation o{points.p[i], from_sensor / std::max(range_m, 1e-9), points.sigma_m[i]};
    if (options.residual == Residual::kAlongRay) {
      const Meeting meeting = MeetSurface(model, o);
      const double cosine = std::abs(meeting.incline);
      if (!meeting.found || cosine < kGrazing_cos) continue;
      const double lateral_m =
          options.noise.LateralSigma_m(range_m, std::acos(std::min(1.0, cosine)));
      const double tan2 = 1 / (cosine * cosine) - 1;
      o.sigma_m = std::sqrt(o.sigma_m * o.sigma_m + lateral_m * lateral_m * tan2);
    }
    out.push_back(o);
  }
  return out;
}

constexpr double kC2 = kCauchy_sigma * kCauchy_sigma;

// Weight of a residual, in standard deviations, under the Cauchy loss.
double WeightOf(double residual) { return 1 / (1 + residual * residual / kC2); }

template <ShapeModel M>
struct Normal {
  typename Refined<M>::Information information = Refined<M>::Information::Zero();
  typename M::Parameters slope = M::Parameters::Zero();
  double loss = 0;
  double squares = 0;
};

template <ShapeModel M>
Normal<M> Accumulate(const M& model, const std::vector<Observation>& observations,
                     const RefineOptions& options) {
  Normal<M> sum;
  for (const Observation& o : observations) {
    Linearised<M> at = Linearise(model, o, options.residual);
    if constexpr (DirectedModel<M>) {
      if (options.axis == AxisFreedom::kHeld) {
        at.gradient.template segment<2>(M::kFirstTilt).setZero();
      }
    }
    const double r2 = at.residual * at.residual;
    const double weight = WeightOf(at.residual);
    sum.information.noalias() += weight * at.gradient * at.gradient.transpose();
    sum.slope += weight * at.residual * at.gradient;
    sum.loss += kC2 * std::log1p(r2 / kC2);
    sum.squares += weight * r2;
  }
  if constexpr (DirectedModel<M>) {
    // The held parameters do not move: any positive pivot keeps them in place.
    if (options.axis == AxisFreedom::kHeld) {
      sum.information.diagonal().template segment<2>(M::kFirstTilt).setOnes();
    }
  }
  return sum;
}

// True if the points determine the parameters: no pivot vanishes once the diagonal is scaled to
// one.
template <class Matrix>
bool IsDetermined(const Matrix& information) {
  const auto diagonal = information.diagonal().array();
  if (!(diagonal.minCoeff() > 0) || !diagonal.isFinite().all()) return false;
  const auto scale = diagonal.sqrt().inverse().matrix().asDiagonal();
  const Matrix scaled = scale * information * scale;
  return MinPivot(scaled) > kMinPivot;
}

}  // namespace

template <ShapeModel M>
std::optional<Refined<M>> Refine(const M& start, const ModelPoints& points,
                                 std::span<const std::uint32_t> inliers,
                                 const RefineOptions& options) {
  const std::vector<Observation> observations = Observe(start, points, inliers, options);
  if (observations.size() < 2 * static_cast<std::size_t>(M::kParameterCount)) return std::nullopt;
  M model = start;
  Normal<M> sum = Accumulate(model, observations, options);
  double damping = kFirstDamping;
  for (int iteration = 0; iteration < options.max_iterations; ++iteration) {
    if (!IsDetermined(sum.information)) return std::nullopt;
    auto damped = sum.information;
    damped.diagonal() *= 1 + damping;
    const M moved = model.Moved(-SolveSymmetric(damped, sum.slope));
    const Normal<M> next = Accumulate(moved, observations, options);
    if (next.loss < sum.loss) {
      const bool converged = sum.loss - next.loss < kMinDecrease * sum.loss;
      model = moved;
      sum = next;
      damping = std::max(damping * 0.1, 1e-12);
      if (converged) break;
    } else {
      damping *= 10;
      if (kMinDecrease * damping > 1) break;
    }
  }
  if (!IsDetermined(sum.information)) return std::nullopt;
  return Refined<M>{.model = model,
                    .information = sum.information,
                    .chi_square = sum.squares / static_cast<double>(observations.size()),
                    .points_used = static_cast<int>(observations.size())};
}

Eigen::MatrixXd WarpOf(const std::vector<Vector3>& places, const Eigen::MatrixXd& gradients) {
  const auto count = static_cast<Eigen::Index>(places.size());
  Eigen::MatrixXd correlation(count, count);
  for (Eigen::Index a = 0; a < count; ++a) {
    for (Eigen::Index b = 0; b <= a; ++b) {
      const double apart =
          (places[static_cast<std::size_t>(a)] - places[static_cast<std::size_t>(b)]).norm() /
          kWarpCorrelation_m;
      correlation(a, b) = correlation(b, a) = std::exp(-0.5 * apart * apart);
    }
  }
  return gradients.transpose() * correlation * gradients;
}

template <ShapeModel M>
typename Refined<M>::Information WarpOfGradient(const M& model, const ModelPoints& points,
                                                std::span<const std::uint32_t> inliers,
                                                const RefineOptions& options) {
  const double warp_m = options.noise.WarpSigma_m();
  const std::vector<Observation> all = Observe(model, points, inliers, options);
  if (warp_m == 0 || all.empty()) return Refined<M>::Information::Zero();
  const std::size_t stride = (all.size() + kWarpPoints - 1) / kWarpPoints;
  std::vector<Vector3> places;
  Eigen::MatrixXd gradients((all.size() + stride - 1) / stride, M::kParameterCount);
  for (std::size_t k = 0; k < all.size(); k += stride) {
    const Linearised<M> at = Linearise(model, all[k], options.residual);
    const double turned =
        options.residual == Residual::kAlongRay ? 1.0 : model.Normal(all[k].p).dot(all[k].ray);
    gradients.row(static_cast<Eigen::Index>(places.size())) =
        WeightOf(at.residual) * turned * warp_m / all[k].sigma_m * at.gradient.transpose();
    places.push_back(all[k].p);
  }
  const double each_stands_for =
      static_cast<double>(all.size()) / static_cast<double>(places.size());
  return each_stands_for * each_stands_for * WarpOf(places, gradients);
}

template std::optional<Refined<PlaneModel>> Refine(const PlaneModel&, const ModelPoints&,
                                                   std::span<const std::uint32_t>,
                                                   const RefineOptions&);
template std::optional<Refined<SphereModel>> Refine(const SphereModel&, const ModelPoints&,
                                                    std::span<const std::uint32_t>,
                                                    const RefineOptions&);
template std::optional<Refined<CylinderModel>> Refine(const CylinderModel&, const ModelPoints&,
                                                      std::span<const std::uint32_t>,
                                                      const RefineOptions&);
template std::optional<Refined<ConeModel>> Refine(const ConeModel&, const ModelPoints&,
                                                  std::span<const std::uint32_t>,
                                                  const RefineOptions&);

template Refined<PlaneModel>::Information WarpOfGradient(const PlaneModel&, const ModelPoints&,
                                                         std::span<const std::uint32_t>,
                                                         const RefineOptions&);
template Refined<SphereModel>::Information WarpOfGradient(const SphereModel&, const ModelPoints&,
                                                          std::span<const std::uint32_t>,
                                                          const RefineOptions&);
template Refined<CylinderModel>::Information WarpOfGradient(const CylinderModel&,
                                                            const ModelPoints&,
                                                            std::span<const std::uint32_t>,
                                                            const RefineOptions&);
template Refined<ConeModel>::Information WarpOfGradient(const ConeModel&, const ModelPoints&,
                                                        std::span<const std::uint32_t>,
                                                        const RefineOptions&);

}  // namespace cwm::perception
