#include "perception/primitive_fit/primitive_fit_misfit.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "collision/geometry/signed_distance.h"
#include "perception/cloud/tolerances.h"

namespace cwm::perception {
namespace {

// chosen: the least cosine of a ray's incidence; at grazing rays the lateral noise would grow
// without bound.
constexpr double kMinIncidence_cos = 0.2;

// One row per point: the first terms of the series of the warp's correlation exp(-d^2 / (2 l^2)),
// so that the products of two rows approximate it.
Eigen::MatrixXd WarpTerms(const PointsOnGround& points) {
  Vector3 middle = Vector3::Zero();
  for (const Vector3& p : points.p_G) middle += p / static_cast<double>(points.p_G.size());
  const Matrix3 across = BasisFromZ((middle - points.viewpoint_G).normalized());
  Eigen::MatrixXd terms(static_cast<Eigen::Index>(points.p_G.size()),
                        Eigen::Index{QuadricTerms::SizeAtCompileTime});
  for (Eigen::Index i = 0; i < terms.rows(); ++i) {
    const Vector3 away = points.p_G[static_cast<std::size_t>(i)] - middle;
    const Vector2 x = (across.transpose() * away).head<2>() / kWarpCorrelation_m;
    terms.row(i) << 1, x.x(), x.y(), std::sqrt(0.5) * x.x() * x.x(), x.x() * x.y(),
        std::sqrt(0.5) * x.y() * x.y();
    terms.row(i) *= std::exp(-0.5 * x.squaredNorm());
  }
  return terms;
}

}  // namespace

double DerivativeAlongRay(const Shape& shape, const Pose& X_SG, const Vector3& p,
                          const Vector3& viewpoint) {
  const Vector3 farther = p + kDerivativeStep * (p - viewpoint).normalized();
  return (SignedDistance_m(shape, X_SG * farther) - SignedDistance_m(shape, X_SG * p)) /
         kDerivativeStep;
}

Misfit MisfitOf(const PlacedPrimitive& solid, const Eigen::VectorXd& residuals,
                const PointsOnGround& points) {
  const Pose X_SG = solid.X_GS.inverse(Eigen::Isometry);
  Misfit misfit{residuals, Eigen::VectorXd(residuals.size())};
  for (Eigen::Index i = 0; i < residuals.size(); ++i) {
    const Vector3& p = points.p_G[static_cast<std::size_t>(i)];
    misfit.along_ray(i) = DerivativeAlongRay(solid.shape, X_SG, p, points.viewpoint_G);
  }
  return misfit;
}

double ValueOf(const Misfit& misfit, int parameters, const PointsOnGround& points,
               const FitContext& c) {
  const Eigen::Index count = misfit.residuals.size();
  const double each = c.IndependentSamples(c.points.size()) / static_cast<double>(count);
  Eigen::MatrixXd terms = WarpTerms(points);
  double squares = 0;
  Eigen::VectorXd pulled = misfit.residuals;
  for (Eigen::Index i = 0; i < count; ++i) {
    const double square = pulled(i) * pulled(i);
    squares += std::min(square, kTruncatedSquare);
    if (square > kTruncatedSquare) pulled(i) = 0, terms.row(i).setZero();
    terms.row(i) *=
        c.noise.WarpSigma_m() * misfit.along_ray(i) / points.sigma_m[static_cast<std::size_t>(i)];
  }
  const Eigen::VectorXd toward = each * terms.transpose() * pulled;
  Eigen::MatrixXd information = each * terms.transpose() * terms;
  information.diagonal().array() += 1;
  squares -= toward.dot(information.ldlt().solve(toward)) / each;
  return CriterionOf(squares / static_cast<double>(count), c.points.size(), parameters, c).value;
}

void SetNoiseAcrossSurface(const PlacedPrimitive& solid, const SensorNoise& noise,
                           PointsOnGround& points) {
  const Pose X_SG = solid.X_GS.inverse(Eigen::Isometry);
  for (std::size_t i = 0; i < points.p_G.size(); ++i) {
    const Vector3& p = points.p_G[i];
    const double along_ray = DerivativeAlongRay(solid.shape, X_SG, p, points.viewpoint_G);
    const double cosine = std::min(1.0, std::abs(along_ray));
    const double lateral_m = noise.LateralSigma_m((p - points.viewpoint_G).norm(),
                                                  std::acos(std::max(cosine, kMinIncidence_cos)));
    points.sigma_m[i] =
        std::hypot(cosine * points.sigma_m[i], std::sqrt(1 - cosine * cosine) * lateral_m);
  }
}

}  // namespace cwm::perception
