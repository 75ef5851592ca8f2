#include "perception/fit/disc_wall.h"

#include <algorithm>
#include <cmath>

#include "perception/cloud/tolerances.h"
#include "perception/fit/model_selection.h"
#include "perception/fit/rim.h"

namespace cwm::perception {
namespace {

// chosen: the least share of the largest number of points on a wall of any slope that counts as
// nearly as many; smaller differences are chance.
constexpr double kMinShareOfBest = 0.95;
// chosen: the step between the slopes that are tried; 5 cm below the rim it is a third of the
// distance gate.
constexpr double kSlopeStep = 0.02;
// chosen: in rim radii, how far from the axis a wall behind the disc may reach.
constexpr double kReach = 1.4;

std::vector<char> BehindDisc(const PlaneModel& face, const Rim& rim, const FitContext& c,
                             const std::vector<char>& available) {
  std::vector<char> behind(available.size(), 0);
  for (std::size_t i = 0; i < available.size(); ++i) {
    if (!available[i] || face.Distance_m(c.points.p[i]) > -c.points.gate_m[i]) continue;
    const Vector3 x = c.points.p[i] - rim.center;
    const double away_m = (x - face.normal.dot(x) * face.normal).norm();
    behind[i] = away_m <= kReach * rim.radius_m;
  }
  return behind;
}

Vector3 AxisOf(const PlaneModel& face, const FitContext& c) {
  const double along = face.normal.dot(c.ground.up);
  if (std::abs(along) > std::cos(kUprightWithin_rad)) {
    return along > 0 ? c.ground.up : Vector3(-c.ground.up);
  }
  return face.normal;
}

ShapeFit WithSlope(const ConeModel& straight, double slope, const FitContext& c,
                   const std::vector<char>& behind) {
  ShapeFit fit;
  fit.axis = AxisFreedom::kHeld;
  ConeModel cone = straight;
  cone.slope = slope;
  fit.model = cone;
  if (slope == 0) {
    fit.model = CylinderModel{.point = cone.point, .axis = cone.axis, .radius_m = cone.radius_m};
  }
  // Near the rim and at grazing incidence normals are unreliable, so only the distance counts.
  for (std::uint32_t i = 0; i < behind.size(); ++i) {
    if (behind[i] && std::abs(cone.Distance_m(c.points.p[i])) <= c.points.gate_m[i]) {
      fit.inliers.push_back(i);
    }
  }
  fit.inliers = c.connectivity.LargestComponent(fit.inliers);
  return fit;
}

// Returns the wall with the mean of the slopes that nearly as many points agree with as with the
// best; a straight wall if it has nearly as many. Empty for a kind that is not searched for.
std::optional<ShapeFit> BestSlope(const ConeModel& straight, const FitContext& c,
                                  const std::vector<char>& behind) {
  ShapeFit upright = WithSlope(straight, 0, c, behind);
  if (!c.options.search_cones) {
    return c.options.search_cylinders ? std::optional(std::move(upright)) : std::nullopt;
  }
  constexpr int kSteps = static_cast<int>(kMaxCupSlope / kSlopeStep);
  std::vector<double> counts;  // inliers of the slopes from -kSteps to kSteps steps
  for (int k = -kSteps; k <= kSteps; ++k) {
    counts.push_back(
        static_cast<double>(WithSlope(straight, k * kSlopeStep, c, behind).inliers.size()));
  }
  const double nearly = kMinShareOfBest * *std::max_element(counts.begin(), counts.end());
  if (c.options.search_cylinders && static_cast<double>(upright.inliers.size()) >= nearly) {
    return upright;
  }
  double sum = 0, good = 0;
  int step = -kSteps;
  for (const double count : counts) {
    if (count >= nearly) {
      sum += step * kSlopeStep;
      ++good;
    }
    ++step;
  }
  if (std::abs(sum / good) < kMinSlope) return std::nullopt;
  return WithSlope(straight, sum / good, c, behind);
}

// A rough covariance of a wall known from a handful of points. The rim, which is measured again
// later, is not counted; centre and radius are known as well as a height.
Eigen::MatrixXd RoughCovariance(const ShapeFit& fit, const FitContext& c) {
  const int size = ParameterCount(fit.model);
  Eigen::MatrixXd covariance =
      kGroundNoise_m * kGroundNoise_m * Eigen::MatrixXd::Identity(size, size);
  covariance.block<2, 2>(ConeModel::kFirstTilt, ConeModel::kFirstTilt) =
      kUpSigma_rad * kUpSigma_rad * Eigen::Matrix2d::Identity();
  if (size == ConeModel::kParameterCount) {
    const double samples = std::max(1.0, c.IndependentSamples(fit.inliers.size()));
    covariance(ConeModel::kSlope, ConeModel::kSlope) = kSlopeStep * kSlopeStep * (1 + 4 / samples);
  }
  return covariance;
}

}  // namespace

std::optional<ShapeFit> FindWallBehindDisc(const ShapeFit& disc, const FitContext& context,
                                           const std::vector<char>& available) {
  const auto* face = std::get_if<PlaneModel>(&disc.model);
  if (face == nullptr) return std::nullopt;
  const std::optional<Rim> rim = MeasureRim(*face, context);
  if (!rim || rim->scatter_m > kMaxRimScatter * rim->radius_m) return std::nullopt;
  if (rim->radius_m > context.options.max_radius_m) return std::nullopt;
  const std::vector<char> behind = BehindDisc(*face, *rim, context, available);
  const ConeModel straight{
      .point = rim->center, .axis = AxisOf(*face, context), .radius_m = rim->radius_m};
  std::optional<ShapeFit> wall = BestSlope(straight, context, behind);
  if (!wall) return std::nullopt;
  const auto all = static_cast<double>(std::count(behind.begin(), behind.end(), 1));
  const auto on = static_cast<double>(wall->inliers.size());
  if (on * context.points.weight < kTwoSamples || on < kMainShare * all) {
    return std::nullopt;
  }
  wall->covariance = RoughCovariance(*wall, context);
  return wall;
}

}  // namespace cwm::perception
