// A model fitted to the points that it explains.
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

// Unit axis turned by the written rule, so that a second scan flips no frame: up; if level (within
// 1 degree), to +x; if that too, to +y.
Vector3 CanonicalAxis(const Vector3& axis, const Vector3& up);

// derived: of an axis that is held to up, where up is the normal of a support: the slow warp tilts
// the plane of a table of one metre by kSlowWarp_m sqrt(12) / (1 m sqrt(12 independent patches));
// on simulated ones by 1.1 mrad rms. Smaller supports are known less well than this says.
inline constexpr double kUpSigma_rad = kSlowWarp_m;

// What fits are made from; everything outlives them.
struct FitContext {
  const ModelPoints& points;
  const Octree& octree;
  const Connectivity& connectivity;
  const SensorNoise& noise;
  const ModelerOptions& options;
  const Work& work;
  Ground ground = {};
  FreeRays free = {};

  // Independent samples behind `count` model points (neighbouring residuals are correlated).
  double IndependentSamples(std::size_t count) const {
    return static_cast<double>(count) * points.weight / kPointsPerIndependentSample;
  }
};

struct ShapeFit {
  AnyModel model;
  AxisFreedom axis = AxisFreedom::kFree;  // held: to up, two degrees of freedom less
  std::vector<std::uint32_t> inliers;     // model points, one connected component, ascending
  Eigen::MatrixXd covariance;             // of the local parameters; empty before FinishFit
  // Inliers and what lies on the surface beside them whatever its normal says: normals are rounded
  // at edges, so the shape's extent is that of these. Inliers are in it twice: they are surer to be
  // of it. Empty before the shape is extracted.
  std::vector<std::uint32_t> covered;
};

// Alternates inlier selection among the available points (one flag each) with refinement of the
// orthogonal residuals, from `start`. Cones begin with a stricter gate (paper, section V). Nothing
// when fewer than min_inliers measured points are left, or a radius leaves its limits.
std::optional<ShapeFit> FitShape(const AnyModel& start, AxisFreedom axis, const FitContext& context,
                                 const std::vector<char>& available);

// The largest connected component of the available points within the model's gates, ascending.
std::vector<std::uint32_t> ConnectedInliers(const AnyModel& model, const FitContext& context,
                                            const std::vector<char>& available);

int DegreesOfFreedom(const AnyModel& model, AxisFreedom axis);

// The last refinement, of the residual along the sensor's ray; an axis or normal within 3 degrees
// of up is made to point up when the criterion allows it; one that is held stays. Sets the
// covariance. Nothing when the result breaks the limits of FitShape.
std::optional<ShapeFit> FinishFit(const ShapeFit& fit, const FitContext& context,
                                  const std::vector<char>& available);

// n_eff times the mean of min(residual^2 / sigma^2, 9) plus k ln n_eff. Smaller is better; a
// difference above kDecisive is decisive (Kass and Raftery 1995).
struct Criterion {
  double value = 0;
  double rms_sigma = 0;  // root of the mean truncated square
};
// derived: of what is beyond the distance gate.
inline constexpr double kTruncatedSquare = kDistanceGate_sigma * kDistanceGate_sigma;
// cited: decisive evidence (Kass and Raftery 1995).
inline constexpr double kDecisive = 10;
// chosen: things stand upright more often than they lean by little. Of upright cups seen in part,
// warp prefers a leaning can by up to 25; what truly lies or leans differs by hundreds.
inline constexpr double kUprightPrior = 30;

// Of `count` model points.
Criterion CriterionOf(double mean_square, std::size_t count, int parameters,
                      const FitContext& context);

// Over the listed points; those whose normal contradicts the model count as far away.
Criterion EvaluateCriterion(const AnyModel& model, AxisFreedom axis, const FitContext& context,
                            const std::vector<std::uint32_t>& listed);
// For several planes at once, each point counting for the nearest that agrees with its normal.
Criterion EvaluateCriterion(const std::vector<PlaneModel>& planes, const FitContext& context,
                            const std::vector<std::uint32_t>& listed);

}  // namespace cwm::perception
