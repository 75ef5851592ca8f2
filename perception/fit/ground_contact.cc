#include "perception/fit/ground_contact.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <variant>

#include "perception/cloud/tolerances.h"
#include "perception/fit/solid.h"

namespace cwm::perception {
namespace {

// derived: one standard deviation of the height of a support.
constexpr double kContact_m = kGroundNoise_m / kDistanceGate_sigma;

// Heights of the lowest points of both end circles of the seen length, or of a sphere.
using Heights = Eigen::VectorXd;

// The ends of a wall's seen length, relative to its reference point.
Interval EndsOf(const ConeModel& wall, const ShapeFit& fit, const ModelPoints& points) {
  Interval ends = ExtentAlong(wall.axis, points, fit.inliers);
  const double origin_m = wall.axis.dot(wall.point);
  return {ends.low_m - origin_m, ends.high_m - origin_m};
}

Heights LowestHeights(const SphereModel& sphere, const Interval&, const Ground& ground) {
  return Heights::Constant(1, ground.Height_m(sphere.center) - sphere.radius_m);
}

template <class Axial>
Heights LowestHeights(const Axial& axial, const Interval& ends, const Ground& ground) {
  const ConeModel& wall = axial.AsCone();
  const double along = wall.axis.dot(ground.up);
  const double across = std::sqrt(std::max(0.0, 1 - along * along));
  Heights heights(2);
  for (int k = 0; k < 2; ++k) {
    const double at_m = k == 0 ? ends.low_m : ends.high_m;
    heights(k) = ground.Height_m(wall.point + at_m * wall.axis) -
                 std::max(0.0, wall.RadiusAt_m(at_m)) * across;
  }
  return heights;
}

bool CanRestOnGround(const PlaneModel&, const Ground&) { return false; }
bool CanRestOnGround(const SphereModel& m, const Ground& ground) {
  return ground.known && m.side == SeenFrom::kOutside;
}
template <class Axial>
bool CanRestOnGround(const Axial& m, const Ground& ground) {
  return ground.known && m.side == SeenFrom::kOutside &&
         std::abs(m.axis.dot(ground.up)) < std::cos(kSameDirection_rad);
}

Interval EndsOf(const SphereModel&, const ShapeFit&, const ModelPoints&) { return {}; }
template <class Axial>
Interval EndsOf(const Axial& m, const ShapeFit& fit, const ModelPoints& points) {
  return EndsOf(m.AsCone(), fit, points);
}

template <ShapeModel M>
Eigen::MatrixXd Derivatives(const M& model, const Interval& ends, const Ground& ground) {
  const Heights heights = LowestHeights(model, ends, ground);
  Eigen::MatrixXd rows(heights.size(), M::kParameterCount);
  for (int k = 0; k < M::kParameterCount; ++k) {
    typename M::Parameters step = M::Parameters::Zero();
    step(k) = kDerivativeStep;
    rows.col(k) = (LowestHeights(model.Moved(step), ends, ground) - heights) / kDerivativeStep;
  }
  return rows;
}

// Returns the ends that touch: those below the ground, or near it within their uncertainty.
std::vector<Eigen::Index> Touching(const Heights& heights, const Eigen::MatrixXd& rows,
                                   const Eigen::MatrixXd& covariance) {
  std::vector<Eigen::Index> touching;
  for (Eigen::Index h = 0; h < heights.size(); ++h) {
    const double variance = rows.row(h).dot(covariance * rows.row(h).transpose());
    const double near_m = kDistanceGate_sigma * std::sqrt(variance + kContact_m * kContact_m);
    if (heights(h) < near_m) touching.push_back(h);
  }
  return touching;
}

// A Kalman update with the measurement "these ends are at height 0", linearised again a few times;
// tilts are at most a tenth of a radian.
template <ShapeModel M>
M Rested(M model, const Interval& ends, const Ground& ground, Eigen::MatrixXd& covariance) {
  const std::vector<Eigen::Index> touching =
      Touching(LowestHeights(model, ends, ground), Derivatives(model, ends, ground), covariance);
  if (touching.empty()) return model;
  Eigen::MatrixXd gain, rows;
  for (int round = 0; round < kFitRounds; ++round) {
    rows = Derivatives(model, ends, ground)(touching, Eigen::all).eval();
    const Eigen::MatrixXd spread =
        rows * covariance * rows.transpose() +
        kContact_m * kContact_m * Eigen::MatrixXd::Identity(rows.rows(), rows.rows());
    gain = covariance * rows.transpose() * spread.inverse();
    const Heights heights = LowestHeights(model, ends, ground)(touching).eval();
    const typename M::Parameters step = -gain * heights;
    model = model.Moved(step);
  }
  covariance = (covariance - gain * rows * covariance).eval();
  return model;
}

template <ShapeModel M>
std::optional<ShapeFit> RestOne(const M& model, const ShapeFit& fit, const FitContext& c,
                                const std::vector<char>& available) {
  ShapeFit rested = fit;
  const Interval ends = EndsOf(model, fit, c.points);
  const M placed = Rested(model, ends, c.ground, rested.covariance);
  if (LowestHeights(placed, ends, c.ground).minCoeff() < -kGroundNoise_m) return std::nullopt;
  rested.model = placed;
  rested.inliers = ConnectedInliers(rested.model, c, available);
  const double points = static_cast<double>(rested.inliers.size()) * c.points.weight;
  if (points < c.options.min_inliers) return std::nullopt;
  return rested;
}
std::optional<ShapeFit> RestOne(const PlaneModel&, const ShapeFit& fit, const FitContext&,
                                const std::vector<char>&) {
  return fit;
}

}  // namespace

bool CanRestOnGround(const ShapeFit& fit, const FitContext& context) {
  return std::visit([&](const auto& m) { return CanRestOnGround(m, context.ground); }, fit.model);
}

std::optional<ShapeFit> RestOnGround(const ShapeFit& fit, const FitContext& context,
                                     const std::vector<char>& available) {
  return std::visit([&](const auto& m) { return RestOne(m, fit, context, available); }, fit.model);
}

}  // namespace cwm::perception
