#include "perception/solids/round_solid.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "collision/geometry/coefficients.h"
#include "perception/cloud/normals.h"
#include "perception/cloud/tolerances.h"
#include "perception/fit/rim.h"

namespace cwm::perception {
namespace {

// derived: the least share of a single disc's rim that must be seen: most of the half whose edge is
// sure to end in a depth jump.
constexpr double kMinOfRim = kMainShare / 2;

// The ends as heights along the axis, relative to the cone's point.
struct Ends {
  double bottom_m = 0;
  double top_m = 0;
};

struct PlacedSolid {
  Pose X_MS;
  Shape shape;
};

PlacedSolid Place(const SphereModel& m, const Ends&) {
  Pose X = Pose::Identity();
  X.translation() = m.center;
  return {X, Sphere{.radius_m = m.radius_m}};
}

Pose OnAxis(const ConeModel& m, const Ends& ends) {
  Pose X = Pose::Identity();
  X.linear() = BasisFromZ(m.axis);
  X.translation() = m.point + 0.5 * (ends.bottom_m + ends.top_m) * m.axis;
  return X;
}

PlacedSolid Place(const CylinderModel& m, const Ends& ends) {
  return {OnAxis(m.AsCone(), ends),
          Cylinder{.radius_m = m.radius_m, .length_m = ends.top_m - ends.bottom_m}};
}

PlacedSolid Place(const ConeModel& m, const Ends& ends) {
  return {OnAxis(m, ends), Cone{.radius_bottom_m = std::max(0.0, m.RadiusAt_m(ends.bottom_m)),
                                .radius_top_m = std::max(0.0, m.RadiusAt_m(ends.top_m)),
                                .length_m = ends.top_m - ends.bottom_m}};
}

// Standard deviations of the shape's coefficients, propagated from the local parameters.
template <ShapeModel M>
std::vector<double> CoefficientSigmas(const M& model, const Ends& ends,
                                      const Eigen::MatrixXd& covariance) {
  if (covariance.rows() != M::kParameterCount) return {};
  return PropagatedSigmas(
      [&](const Eigen::VectorXd& step) {
        const PlacedSolid placed = Place(model.Moved(typename M::Parameters(step)), ends);
        return Coefficients(placed.shape, placed.X_MS);
      },
      covariance);
}

double MeanSigma_m(const ShapeFit& fit, const FitContext& c) {
  double sum = 0;
  for (std::uint32_t i : fit.inliers) sum += c.points.sigma_m[i];
  return sum / static_cast<double>(fit.inliers.size());
}

// True if the disc is a cap of the wall: normal to the axis, facing away from the wall, and within
// its radius, which the fit knows to `section_sigma_m`. Sets height_m to where the axis meets the
// disc.
bool IsCap(const PlaneModel& plane, const ShapeFit& disc, const ConeModel& wall, const Ends& ends,
           double section_sigma_m, const FitContext& c, double& height_m) {
  const double along = plane.normal.dot(wall.axis);
  if (std::abs(along) < std::cos(kSameDirection_rad)) return false;
  // The height at which the axis meets the plane.
  height_m = plane.normal.dot(plane.point - wall.point) / along;
  const double end_m = along > 0 ? ends.top_m : ends.bottom_m;
  // The largest gap between a cap and the last points of the wall. The wall ends where its surface
  // no longer explains the points; near the rim the windows of the normals cover both surfaces, so
  // the normals agree with neither.
  const double slack_m = kExplainedWithin_m + double{kNormalRadius_sigma} * MeanSigma_m(disc, c);
  if (std::abs(height_m - end_m) > slack_m) return false;
  double off_axis_m = 0;
  for (std::uint32_t i : disc.inliers) {
    const Vector3 x = c.points.p[i] - wall.point;
    off_axis_m = std::max(off_axis_m, (x - wall.axis.dot(x) * wall.axis).norm());
  }
  return off_axis_m <= wall.RadiusAt_m(height_m) + slack_m + kDistanceGate_sigma * section_sigma_m;
}

// The standard deviation of the centre and radius of a wall's cross section together, at most a
// third of the radius: a wall that is seen nearly flat constrains neither, but no cap is twice as
// wide.
double SectionSigma_m(const Eigen::MatrixXd& covariance, double radius_m) {
  const double variance = std::max(covariance(0, 0), covariance(1, 1)) + covariance(4, 4);
  return std::min(std::sqrt(variance), radius_m / kDistanceGate_sigma);
}

// Applies the caps of the wall to its ends and returns them.
std::vector<PlaneModel> ApplyCaps(const ConeModel& wall, double section_sigma_m,
                                  const std::vector<ShapeFit>& fits, const FitContext& c,
                                  Ends& ends, std::vector<char>& used,
                                  std::vector<std::uint32_t>& inliers) {
  const Ends of_wall = ends;
  std::vector<PlaneModel> caps;
  for (std::size_t k = 0; k < fits.size(); ++k) {
    const auto* plane = std::get_if<PlaneModel>(&fits[k].model);
    double height_m = 0;
    if (plane == nullptr || used[k]) continue;
    if (!IsCap(*plane, fits[k], wall, of_wall, section_sigma_m, c, height_m)) continue;
    (plane->normal.dot(wall.axis) > 0 ? ends.top_m : ends.bottom_m) = height_m;
    used[k] = 1;
    caps.push_back(*plane);
    inliers.insert(inliers.end(), fits[k].inliers.begin(), fits[k].inliers.end());
  }
  return caps;
}

// Extends an upright solid to the ground if it ends just above it, and shortens it if it ends
// below.
void StandOnGround(const ConeModel& wall, const Ground& ground, Ends& ends) {
  if (!ground.known || wall.axis.dot(ground.up) < std::cos(kSameDirection_rad)) return;
  const double ground_m = -ground.Height_m(wall.point) / wall.axis.dot(ground.up);
  // An inclined foot touches with its lower rim.
  const double tilt_sine = wall.axis.cross(ground.up).norm();
  const double foot_m = ground_m + std::abs(wall.RadiusAt_m(ground_m)) * tilt_sine;
  if (ends.bottom_m < foot_m || ends.bottom_m - foot_m < kStandingGap_m) ends.bottom_m = foot_m;
}

// Lifts a solid that reaches into the ground by no more than noise. False if it reaches deeper,
// which means that the fit is wrong.
bool LiftAboveGround(Solid& solid, const Ground& ground, double sigma_m) {
  if (!ground.known) return true;
  const double depth_m = -LowestHeight_m(solid, ground);
  if (depth_m <= 0) return true;
  if (depth_m > kGroundNoise_m + kDistanceGate_sigma * sigma_m) return false;
  solid.X_MS.translation() += depth_m * ground.up;
  return true;
}

std::optional<Solid> MakeSphere(const SphereModel& sphere, const ShapeFit& fit, const FitContext& c,
                                const Ground& ground) {
  if (sphere.side == SeenFrom::kInside) return std::nullopt;
  const PlacedSolid placed = Place(sphere, {});
  Solid solid{placed.X_MS, placed.shape, fit.inliers,
              CoefficientSigmas(sphere, {}, fit.covariance)};
  if (!LiftAboveGround(solid, ground, MeanSigma_m(fit, c))) return std::nullopt;
  return solid;
}

template <class Axial>
std::optional<Solid> MakeAxial(Axial model, const ShapeFit& fit, const std::vector<ShapeFit>& fits,
                               const FitContext& c, const Ground& ground, std::vector<char>& used) {
  if (model.side == SeenFrom::kInside) return std::nullopt;
  ConeModel wall = model.AsCone();
  const Interval extent = ExtentAlong(wall.axis, c.points, fit.covered);
  const double origin_m = wall.axis.dot(wall.point);
  Ends ends{extent.low_m - origin_m, extent.high_m - origin_m};
  Solid solid;
  solid.inliers = fit.inliers;
  Eigen::MatrixXd covariance = fit.covariance;
  const double sigma_m = SectionSigma_m(covariance, model.radius_m);
  for (const PlaneModel& cap : ApplyCaps(wall, sigma_m, fits, c, ends, used, solid.inliers)) {
    if (const std::optional<Rim> rim = MeasureRim(cap, wall, sigma_m, c)) {
      model = FuseRim(model, *rim, covariance);
      wall = model.AsCone();
    }
  }
  StandOnGround(wall, ground, ends);
  if (!(ends.top_m - ends.bottom_m > c.options.min_radius_m)) return std::nullopt;
  const PlacedSolid placed = Place(model, ends);
  solid.X_MS = placed.X_MS;
  solid.shape = placed.shape;
  solid.parameter_sigma = CoefficientSigmas(model, ends, covariance);
  if (!LiftAboveGround(solid, ground, MeanSigma_m(fit, c))) return std::nullopt;
  return solid;
}

}  // namespace

std::optional<Solid> MakeRoundSolid(const ShapeFit& fit, const std::vector<ShapeFit>& fits,
                                    const FitContext& context, const Ground& ground,
                                    std::vector<char>& used) {
  if (const auto* sphere = std::get_if<SphereModel>(&fit.model)) {
    return MakeSphere(*sphere, fit, context, ground);
  }
  if (const auto* cylinder = std::get_if<CylinderModel>(&fit.model)) {
    return MakeAxial(*cylinder, fit, fits, context, ground, used);
  }
  if (const auto* cone = std::get_if<ConeModel>(&fit.model)) {
    return MakeAxial(*cone, fit, fits, context, ground, used);
  }
  return std::nullopt;
}

std::optional<Solid> MakeDisc(const Solid& plate, const FitContext& c) {
  const auto* flat = std::get_if<Plate>(&plate.shape);
  if (flat == nullptr || !c.options.search_cylinders) return std::nullopt;
  const PlaneModel face{.point = plate.X_MS.translation(), .normal = plate.X_MS.linear().col(2)};
  const std::optional<Rim> rim = MeasureRim(face, c);
  if (!rim || rim->seen < kMinOfRim || rim->scatter_m > kMaxRimScatter * rim->radius_m ||
      rim->radius_m > c.options.max_radius_m) {
    return std::nullopt;
  }
  const ConeModel wall{.point = rim->center - 0.5 * flat->thickness_m * face.normal,
                       .axis = CanonicalAxis(face.normal, c.ground.up),
                       .radius_m = rim->radius_m};
  Solid disc{OnAxis(wall, {}),
             Cylinder{.radius_m = rim->radius_m, .length_m = flat->thickness_m},
             plate.inliers,
             {}};
  if (plate.parameter_sigma.size() < 3) return disc;
  // The rim constrains the centre across the axis, and the face constrains the axis.
  const auto across = rim->basis.leftCols<2>();
  const Vector3 center =
      (across * rim->covariance.topLeftCorner<2, 2>() * across.transpose()).diagonal().cwiseSqrt();
  disc.parameter_sigma.assign(center.begin(), center.end());
  disc.parameter_sigma.insert(disc.parameter_sigma.end(), plate.parameter_sigma.begin(),
                              plate.parameter_sigma.begin() + 3);
  disc.parameter_sigma.push_back(std::sqrt(rim->covariance(2, 2)));
  return disc;
}

}  // namespace cwm::perception
