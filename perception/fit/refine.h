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

// chosen: of the diagonal; flat, since each step changes it tenfold.
inline constexpr double kFirstDamping = 1e-3;

// What is minimised. Noise acts along the ray, so at slanted surfaces the orthogonal distance is
// biased towards the sensor (for cylinders of 15-60 mm under Kinect noise by 0.6 mm); the distance
// along the ray, weighted by the variance sigma_z^2 + sigma_lateral^2 tan^2(incidence), is not. It
// leaves out points of more than 70 degrees of incidence.
enum class Residual { kOrthogonal, kAlongRay };

// chosen: points, all in proportion, that stand for all of a fit: the warp is smooth over many
// of them.
inline constexpr std::size_t kWarpPoints = 96;
// chosen: of linearising a fit again and of leaving out what does not belong to it; each squares
// the error that is left.
inline constexpr int kFitRounds = 3;

enum class AxisFreedom { kFree, kHeld };  // held: the direction of the axis or normal stays

struct RefineOptions {
  Residual residual = Residual::kOrthogonal;
  AxisFreedom axis = AxisFreedom::kFree;
  int max_iterations = 20;  // chosen: fits end by convergence, and this only bounds their work
  SensorNoise noise;        // lateral noise, of residuals along the ray
};

template <ShapeModel M>
struct Refined {
  using Information = Eigen::Matrix<double, M::kParameterCount, M::kParameterCount>;
  M model;
  Information information;  // inverse covariance of the parameters, were the points independent
  double chi_square = 0;    // mean square of the weighted residuals
  int points_used = 0;
};

// Minimises the Cauchy loss of the residuals of the listed points, in units of their standard
// deviation. Nothing when the points do not determine the shape.
template <ShapeModel M>
std::optional<Refined<M>> Refine(const M& start, const ModelPoints& points,
                                 std::span<const std::uint32_t> inliers,
                                 const RefineOptions& options);

// Covariance of a sum of gradients, one row per place, whose errors are those of the sensor's slow
// warp in units of its standard deviation.
Eigen::MatrixXd WarpOf(const std::vector<Vector3>& places, const Eigen::MatrixXd& gradients);

// Covariance of the gradient of the loss that the sensor's slow warp, alike at neighbouring points,
// brings about: the parameters' own is information^-1 * warp * information^-1.
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
