// Non-linear refinement of a shape's parameters on its inliers (paper, section V, Levenberg-
// Marquardt).
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "perception/cloud/sensor_noise.h"
#include "perception/search/any_model.h"
#include "perception/search/model_points.h"

namespace cwm::perception {

// chosen: relative to the diagonal; the choice matters little because each step changes it tenfold.
inline constexpr double kFirstDamping = 1e-3;

// The residual that is minimised. Noise acts along the ray, so at slanted surfaces the orthogonal
// distance is biased toward the sensor (by 0.6 mm for cylinders of 15-60 mm under Kinect noise).
// The distance along the ray, weighted by the variance sigma_z^2 + sigma_lateral^2
// tan^2(incidence), is not biased. Points of more than 70 degrees of incidence are left out of it.
enum class Residual { kOrthogonal, kAlongRay };

// chosen: points, evenly sampled, that represent all of a fit; the warp is smooth over many of
// them.
inline constexpr std::size_t kWarpPoints = 96;
// chosen: rounds of linearising a fit again and of dropping outliers; each round squares the
// remaining error.
inline constexpr int kFitRounds = 3;

enum class AxisFreedom { kFree, kHeld };  // kHeld: the axis or normal keeps its direction

struct RefineOptions {
  Residual residual = Residual::kOrthogonal;
  AxisFreedom axis = AxisFreedom::kFree;
  int max_iterations = 20;  // chosen: bounds the work; fits end by convergence
  SensorNoise noise;        // lateral noise, for residuals along the ray
};

template <ShapeModel M>
struct Refined {
  using Information = Eigen::Matrix<double, M::kParameterCount, M::kParameterCount>;
  M model;
  Information information;  // inverse covariance if the points were independent
  double chi_square = 0;    // mean square of the weighted residuals
  int points_used = 0;
};

// Minimises the Cauchy loss of the residuals of the listed points, in units of their standard
// deviation. Empty if the points do not determine the shape.
template <ShapeModel M>
std::optional<Refined<M>> Refine(const M& start, const ModelPoints& points,
                                 std::span<const std::uint32_t> inliers,
                                 const RefineOptions& options);

// The covariance of a sum of gradients, one row per place, whose errors follow the sensor's slow
// warp, in units of the warp's standard deviation.
Eigen::MatrixXd WarpOf(const std::vector<Vector3>& places, const Eigen::MatrixXd& gradients);

// The covariance of the loss's gradient due to the sensor's slow warp, which is correlated between
// neighbouring points. The parameters' own is information^-1 * warp * information^-1.
template <ShapeModel M>
typename Refined<M>::Information WarpOfGradient(const M& model, const ModelPoints& points,
                                                std::span<const std::uint32_t> inliers,
                                                const RefineOptions& options);

extern template std::optional<Refined<PlaneModel>> Refine(const PlaneModel&, const ModelPoints&,
                                                          std::span<const std::uint32_t>,
                                                          const RefineOptions&);
extern template std::optional<Refined<SphereModel>> Refine(const SphereModel&, const ModelPoints&,
                                                           std::span<const std::uint32_t>,
                                                           const RefineOptions&);
extern template std::optional<Refined<CylinderModel>> Refine(const CylinderModel&,
                                                             const ModelPoints&,
                                                             std::span<const std::uint32_t>,
                                                             const RefineOptions&);
extern template std::optional<Refined<ConeModel>> Refine(const ConeModel&, const ModelPoints&,
                                                         std::span<const std::uint32_t>,
                                                         const RefineOptions&);

extern template Refined<PlaneModel>::Information WarpOfGradient(const PlaneModel&,
                                                                const ModelPoints&,
                                                                std::span<const std::uint32_t>,
                                                                const RefineOptions&);
extern template Refined<SphereModel>::Information WarpOfGradient(const SphereModel&,
                                                                 const ModelPoints&,
                                                                 std::span<const std::uint32_t>,
                                                                 const RefineOptions&);
extern template Refined<CylinderModel>::Information WarpOfGradient(const CylinderModel&,
                                                                   const ModelPoints&,
                                                                   std::span<const std::uint32_t>,
                                                                   const RefineOptions&);
extern template Refined<ConeModel>::Information WarpOfGradient(const ConeModel&, const ModelPoints&,
                                                               std::span<const std::uint32_t>,
                                                               const RefineOptions&);

}  // namespace cwm::perception
