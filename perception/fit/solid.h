// Bounded solids made of fitted surfaces: what enters the world.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "collision/geometry/hybrid_model.h"
#include "perception/cloud/tolerances.h"
#include "perception/fit/ground.h"
#include "perception/fit/shape_fit.h"

namespace cwm::perception {

// Everything in the frame of the model points: parallel to L, origin at ModelPoints::origin_L.
struct Solid {
  Pose X_MS = Pose::Identity();
  Shape shape;
  std::vector<std::uint32_t> inliers;   // model points
  std::vector<double> parameter_sigma;  // as FitQuality has it
  PartRole role = PartRole::kFitted;
  std::shared_ptr<const VesselShell> vessel = nullptr;  // as of a ShapePart
};

// To its surface, p in the solid's frame; a vessel's by its profile.
double SignedDistance_m(const Solid& solid, const Vector3& p);

// Standard deviations of f at 0, propagated from the covariance of its arguments (metres, radians);
// empty where f changes its number of values.
std::vector<double> PropagatedSigmas(
    const std::function<std::vector<double>(const Eigen::VectorXd&)>& f,
    const Eigen::MatrixXd& covariance);

// chosen: directions count as equal within this: orthogonal faces, caps, upright axes. The noise of
// a face of 60 points turns its normal by 3 to 4 degrees.
inline constexpr double kSameDirection_rad = 8 * kDegree;

// derived: a solid that ends above its support by less than this touches it: the band above a
// support is given to the support (3 sigma), and the rim at the foot is often lost.
inline constexpr double kStandingGap_m = kTouching_m;

// Lowest point of a convex solid or plate along -up.
double LowestHeight_m(const Solid& solid, const Ground& ground);

// Of points along a face: about even, or less and less away from the sensor, down to half.
enum class Density { kEven, kFading };

// Interval that the listed points fill along a unit direction, for faces and walls of such density:
// each end lies where a sharp edge would hold the points that noise scatters about it.
struct Interval {
  double low_m = 0, high_m = 0;
  double length_m() const { return high_m - low_m; }
};
Interval ExtentAlong(const Vector3& direction, const ModelPoints& points,
                     const std::vector<std::uint32_t>& listed, Density density = Density::kEven);

}  // namespace cwm::perception
