// Fits a shape model to the points that it explains.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "perception/cloud/work.h"
#include "perception/fit/ground.h"
#include "perception/fit/passing_rays.h"
#include "perception/fit/refine.h"
#include "perception/model/modeler_options.h"
#include "perception/search/connectivity.h"
#include "perception/search/octree.h"

namespace cwm::perception {

// Returns the unit axis with a canonical sign, so that a second scan flips no frame: toward up; if
// it is level (within 1 degree), toward +x; if it is normal to that too, toward +y.
Vector3 CanonicalAxis(const Vector3& axis, const Vector3& up);

// derived: the standard deviation of an axis held to up, if up is the normal of a support. The slow
// warp tilts the plane of a table of one metre by kSlowWarp_m sqrt(12) / (1 m sqrt(12 independent
// patches)); on simulated tables by 1.1 mrad rms. Smaller supports are known less well than this.
inline constexpr double kUpSigma_rad = kSlowWarp_m;

// The inputs of all fits to one object; what it refers to outlives it.
struct FitContext {
  const ModelPoints& points;
  const Octree& octree;
  const Connectivity& connectivity;
  const SensorNoise& noise;
  const ModelerOptions& options;
  const Work& work;
  Ground ground = {};
  FreeRays free = {};

  // The number of independent samples behind `count` model points; neighbouring residuals are
  // correlated.
  double IndependentSamples(std::size_t count) const {
    return static_cast<double>(count) * points.weight / kPointsPerIndependentSample;
  }
};

struct ShapeFit {
  AnyModel model;
  AxisFreedom axis = AxisFreedom::kFree;  // kHeld: fixed to up, two parameters less
  std::vector<std::uint32_t> inliers;     // model points, one connected component, ascending
  Eigen::MatrixXd covariance;             // of the local parameters; empty before FinishFit
  // The inliers, and the available points that lie on the surface beside them whatever their
  // normals are. Normals are rounded at edges, so these points give the shape's extent. Inliers are
  // listed twice, because they belong to it more surely. Empty before the shape is extracted.
  std::vector<std::uint32_t> covered;
};

// Alternates the selection of inliers among the available points (one flag each) with refinement of
// the orthogonal residuals, from `start`. Cones begin with a stricter gate (paper, section V).
// Empty if fewer than min_inliers measured points are left or a radius leaves its limits.
std::optional<ShapeFit> FitShape(const AnyModel& start, AxisFreedom axis, const FitContext& context,
                                 const std::vector<char>& available);

// Returns the largest connected component of the available points within the model's gates,
// ascending.
std::vector<std::uint32_t> ConnectedInliers(const AnyModel& model, const FitContext& context,
                                            const std::vector<char>& available);

int DegreesOfFreedom(const AnyModel& model, AxisFreedom axis);

// The last refinement, of the residual along the sensor's ray, or of the orthogonal one if few rays
// meet the surface well. A free axis or normal within 3 degrees of up is fixed to up if the
// criterion prefers it; a held one stays. Sets the covariance. Empty if the result breaks the
// limits of FitShape.
std::optional<ShapeFit> FinishFit(const ShapeFit& fit, const FitContext& context,
                                  const std::vector<char>& available);

// The Bayesian information criterion: n_eff times the mean of min(residual^2 / sigma^2, 9), plus k
// ln n_eff for k parameters. Smaller is better; a difference above kDecisive is decisive (Kass and
// Raftery 1995).
struct Criterion {
  double value = 0;
  double rms_sigma = 0;  // root of the mean truncated square
};
// derived: the square at the distance gate; larger ones are truncated to it.
inline constexpr double kTruncatedSquare = kDistanceGate_sigma * kDistanceGate_sigma;
// cited: decisive evidence (Kass and Raftery 1995).
inline constexpr double kDecisive = 10;
// chosen: a prior for upright objects, which are more frequent than slightly leaning ones. For an
// upright cup seen in part, warp may favour a leaning can by up to 25; what really lies or leans
// differs by hundreds.
inline constexpr double kUprightPrior = 30;

// The criterion of `count` model points with this mean truncated square.
Criterion CriterionOf(double mean_square, std::size_t count, int parameters,
                      const FitContext& context);

// The criterion of a model over the listed points. Points whose normal contradicts the model count
// as far away.
Criterion EvaluateCriterion(const AnyModel& model, AxisFreedom axis, const FitContext& context,
                            const std::vector<std::uint32_t>& listed);
// The criterion of several planes together. Each point counts for the nearest plane that agrees
// with its normal.
Criterion EvaluateCriterion(const std::vector<PlaneModel>& planes, const FitContext& context,
                            const std::vector<std::uint32_t>& listed);

}  // namespace cwm::perception
