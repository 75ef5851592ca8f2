// Bounded solids made of fitted surfaces, and helpers that measure them.
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

// A bounded solid in the frame of the model points, which is parallel to L with its origin at
// ModelPoints::origin_L.
struct Solid {
  Pose X_MS = Pose::Identity();
  Shape shape;
  std::vector<std::uint32_t> inliers;   // indices of model points
  std::vector<double> parameter_sigma;  // as FitQuality::parameter_sigma
  PartRole role = PartRole::kFitted;
  std::shared_ptr<const VesselShell> vessel = nullptr;  // as ShapePart::vessel
};

// The signed distance of p, in the solid's frame, from the solid's surface; a vessel's by its
// profile.
double SignedDistance_m(const Solid& solid, const Vector3& p);

// Standard deviations of f at 0, propagated from the covariance of its arguments (metres, radians).
// Empty if f changes its number of values.
std::vector<double> PropagatedSigmas(
    const std::function<std::vector<double>(const Eigen::VectorXd&)>& f,
    const Eigen::MatrixXd& covariance);

// chosen: directions of orthogonal faces, caps and upright axes count as equal within this angle.
// The noise of a face of 60 points turns its normal by 3 to 4 degrees.
inline constexpr double kSameDirection_rad = 8 * kDegree;

// derived: a solid that ends less than this above its support touches it: points within 3 sigma of
// a support are assigned to the support, and the rim at the foot is often lost.
inline constexpr double kStandingGap_m = kMaxTouchingGap_m;

// The height of the lowest point of a solid above the ground, in metres.
double LowestHeight_m(const Solid& solid, const Ground& ground);

// The density of points along a face: about even, or fading with the distance from the sensor, to
// half at most.
enum class Density { kEven, kFading };

// The interval that the listed points fill along a unit direction, for faces and walls of this
// density. Each end lies where a sharp edge would hold the points that noise scatters about it.
struct Interval {
  double low_m = 0, high_m = 0;
  double length_m() const { return high_m - low_m; }
};
Interval ExtentAlong(const Vector3& direction, const ModelPoints& points,
                     const std::vector<std::uint32_t>& listed, Density density = Density::kEven);

}  // namespace cwm::perception
