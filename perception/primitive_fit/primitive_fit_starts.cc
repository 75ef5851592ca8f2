#include "perception/primitive_fit/primitive_fit_starts.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <utility>

#include "collision/geometry/aabb.h"
#include "collision/geometry/polygon.h"
#include "perception/cloud/quantile.h"
#include "perception/cloud/tolerances.h"
#include "perception/solids/plane_solid.h"

namespace cwm::perception {
namespace {

// chosen: as a share of the points at either end that noise may scatter beyond it.
constexpr double kBeyondEnds = 0.03;

// chosen: 14 degrees. Leaning starts are turned by this to either side of the principal direction
// of their points.
constexpr double kStartTurn_rad = 0.25;
// derived: the least sine of the elevation of a leaning start: twice the limit, so that a step may
// halve it.
constexpr double kStartLean = kMinLean * 2;
// chosen: the least ratio of the two extents of a face that may be the end of a round solid.
constexpr double kMinRoundness = 0.6;
// derived: the mean absolute slope under the prior kSlopeSpread. Cones start with it and with its
// negative.
constexpr double kStartSlope = kSlopeSpread * std::numbers::sqrt2 * std::numbers::inv_sqrtpi;

double TopOf_m(const PointsOnGround& points) {
  std::vector<double> heights;
  for (const Vector3& p : points.p_G) heights.push_back(p.z());
  return Quantile(std::move(heights), 1 - kBeyondEnds);
}

struct Extent {
  double mid_m = 0, size_m = 0;
};

Extent ExtentOf(const PointsOnGround& points, const Vector3& direction) {
  std::vector<double> values;
  for (const Vector3& p : points.p_G) values.push_back(direction.dot(p));
  const double low_m = Quantile(values, kBeyondEnds);
  const double high_m = Quantile(std::move(values), 1 - kBeyondEnds);
  return {0.5 * (low_m + high_m), high_m - low_m};
}

// The algebraic fit |p|^2 = 2 c . p + k (Kasa 1976).
template <int kDimension>
struct Round {
  Eigen::Matrix<double, kDimension, 1> center;
  double radius_m = 0;
};

template <int kDimension>
std::optional<Round<kDimension>> RoundThrough(const std::vector<Vector3>& points) {
  using Row = Eigen::Matrix<double, kDimension + 1, 1>;
  Eigen::Matrix<double, kDimension + 1, kDimension + 1> normal =
      Eigen::Matrix<double, kDimension + 1, kDimension + 1>::Zero();
  Row right = Row::Zero();
  for (const Vector3& p : points) {
    Row row;
    row << 2 * p.head<kDimension>(), 1;
    normal += row * row.transpose();
    right += p.head<kDimension>().squaredNorm() * row;
  }
  const Row x = normal.ldlt().solve(right);
  const Round<kDimension> round{
      x.template head<kDimension>(),
      std::sqrt(x(kDimension) + x.template head<kDimension>().squaredNorm())};
  if (!x.allFinite() || !(round.radius_m > 0)) return std::nullopt;
  return round;
}

// The least-squares sphere through all points.
std::vector<PrimitiveParameters> BallStarts(const PointsOnGround& points) {
  const auto ball = RoundThrough<3>(points.p_G);
  if (!ball) return {};
  PrimitiveParameters x(4);
  x << ball->center, ball->radius_m;
  return {x};
}

// A circle inscribed in the extent of all points, and one through the points below the top, which
// lie on the wall.
std::vector<PrimitiveParameters> UprightStarts(const PointsOnGround& points) {
  const double top_m = TopOf_m(points);
  const Extent x = ExtentOf(points, Vector3::UnitX()), y = ExtentOf(points, Vector3::UnitY());
  std::vector<PrimitiveParameters> starts;
  starts.emplace_back(Eigen::Vector4d(x.mid_m, y.mid_m, top_m, 0.25 * (x.size_m + y.size_m)));
  std::vector<Vector3> wall;
  for (std::size_t i = 0; i < points.p_G.size(); ++i) {
    if (points.p_G[i].z() < top_m - kNoiseReach_sigma * points.sigma_m[i]) {
      wall.push_back(points.p_G[i]);
    }
  }
  if (wall.size() < kOneSample) return starts;
  if (const auto circle = RoundThrough<2>(wall)) {
    starts.emplace_back(
        Eigen::Vector4d(circle->center.x(), circle->center.y(), top_m, circle->radius_m));
  }
  return starts;
}

double PrincipalYaw_rad(const PointsOnGround& points) {
  Vector2 mean = Vector2::Zero();
  for (const Vector3& p : points.p_G) mean += p.head<2>();
  mean /= static_cast<double>(points.p_G.size());
  Eigen::Matrix2d spread = Eigen::Matrix2d::Zero();
  for (const Vector3& p : points.p_G) {
    spread += (p.head<2>() - mean) * (p.head<2>() - mean).transpose();
  }
  const Vector2 d = Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(spread).eigenvectors().col(1);
  return std::atan2(d.y(), d.x());
}

// Lying cylinders as high as the points, along the principal direction, across it and between both.
// If little more than an end is seen, another start reaches away from the sensor.
std::vector<PrimitiveParameters> LyingStarts(const PointsOnGround& points) {
  const double radius_m = 0.5 * TopOf_m(points);
  const double principal_rad = PrincipalYaw_rad(points);
  std::vector<PrimitiveParameters> starts;
  for (const Vector2& way : {Vector2(1, 0), Vector2(1, 1), Vector2(0, 1), Vector2(-1, 1)}) {
    const double yaw_rad = principal_rad + std::atan2(way.y(), way.x());
    const Vector3 along(std::cos(yaw_rad), std::sin(yaw_rad), 0);
    const Vector3 across(-along.y(), along.x(), 0);
    const Extent length = ExtentOf(points, along);
    const Vector3 mid = length.mid_m * along + ExtentOf(points, across).mid_m * across;
    PrimitiveParameters x(5);
    x << mid.x(), mid.y(), yaw_rad, radius_m, length.size_m;
    starts.push_back(x);
    const double hidden_m = kHiddenRadii * radius_m - length.size_m;
    if (!(hidden_m > 0)) continue;
    const double away = along.dot(mid - points.viewpoint_G) > 0 ? 0.5 : -0.5;
    x.head<2>() += away * hidden_m * along.head<2>();
    x(4) = kHiddenRadii * radius_m;
    starts.push_back(std::move(x));
  }
  return starts;
}

// Leaning cylinders along the principal direction of the points and turned to either side of it.
std::vector<PrimitiveParameters> LeaningStarts(const PointsOnGround& points) {
  Vector3 mean = Vector3::Zero();
  for (const Vector3& p : points.p_G) mean += p / static_cast<double>(points.p_G.size());
  Matrix3 spread = Matrix3::Zero();
  for (const Vector3& p : points.p_G) spread += (p - mean) * (p - mean).transpose();
  Vector3 axis = Eigen::SelfAdjointEigenSolver<Matrix3>(spread).eigenvectors().col(2);
  if (axis.z() < 0) axis = -axis;
  const double yaw_rad = std::atan2(axis.y(), axis.x());
  const Vector3 across(-std::sin(yaw_rad), std::cos(yaw_rad), 0);
  const Extent width = ExtentOf(points, across);
  std::vector<PrimitiveParameters> starts;
  for (const double turn_rad : {-kStartTurn_rad, 0.0, kStartTurn_rad}) {
    const double elevation_rad = std::asin(std::min(1.0, axis.z())) + turn_rad;
    PrimitiveParameters x(6);
    x << mean.x(), mean.y(), yaw_rad, elevation_rad, 0.5 * width.size_m,
        TopOf_m(points) / std::max(kStartLean, std::sin(elevation_rad));
    starts.push_back(std::move(x));
  }
  return starts;
}

// Leaning cylinders behind those faces of a known solid that are about as wide as high, down to the
// ground. An end in view may be all that is seen of a leaning cylinder.
std::vector<PrimitiveParameters> LeaningBehind(const PlacedPrimitive& known) {
  const Aabb bounds = TightBounds(known.shape, Pose::Identity());
  const Vector3 size_m = bounds.sizes();
  std::vector<PrimitiveParameters> starts;
  for (Eigen::Index k = 0; k < 3; ++k) {
    Vector3 axis = known.X_GS.linear().col(k);
    if (axis.z() < 0) axis = -axis;
    const double across_m = size_m((k + 1) % 3), other_m = size_m((k + 2) % 3);
    if (std::min(across_m, other_m) < kMinRoundness * std::max(across_m, other_m)) continue;
    const double elevation_rad = std::asin(std::min(1.0, axis.z()));
    if (std::sin(elevation_rad) < kStartLean) continue;
    const double radius_m = 0.25 * (across_m + other_m);
    const Vector3 face = known.X_GS * bounds.center() + 0.5 * size_m(k) * axis;
    const double length_m = std::max(
        size_m(k), (face.z() - radius_m * std::cos(elevation_rad)) / std::sin(elevation_rad));
    const Vector3 at = face - 0.5 * length_m * axis;
    PrimitiveParameters x(6);
    x << at.x(), at.y(), std::atan2(axis.y(), axis.x()), elevation_rad, radius_m, length_m;
    starts.push_back(std::move(x));
  }
  return starts;
}

std::vector<PrimitiveParameters> BoxStarts(const PointsOnGround& points) {
  std::vector<Vector2> flat;
  for (const Vector3& p : points.p_G) flat.emplace_back(p.head<2>());
  const Polygon hull = ConvexHull(flat);
  if (hull.size() < 3) return {};
  const Rectangle rectangle = SmallestRectangle(hull);
  const Vector2 mid = rectangle.center();
  const Vector2 size = rectangle.bounds.sizes();
  PrimitiveParameters x(6);
  x << mid, std::atan2(rectangle.x.y(), rectangle.x.x()), size, TopOf_m(points);
  return {x};
}

std::vector<PrimitiveParameters> Suggested(PrimitiveKind kind, const PointsOnGround& points) {
  switch (kind) {
    case PrimitiveKind::kBall:
      return BallStarts(points);
    case PrimitiveKind::kUprightCylinder:
    case PrimitiveKind::kUprightCone:
      return UprightStarts(points);
    case PrimitiveKind::kLyingCylinder:
    case PrimitiveKind::kLyingCone:
      return LyingStarts(points);
    case PrimitiveKind::kLeaningCylinder:
      return LeaningStarts(points);
    case PrimitiveKind::kUprightBox:
      return BoxStarts(points);
    case PrimitiveKind::kTiltedBox:  // starts from known solids only
      return {};
  }
  return {};
}

void AppendSlope(double slope, PrimitiveParameters& x) {
  x.conservativeResize(x.size() + 1);
  x(x.size() - 1) = slope;
}

}  // namespace

std::vector<PrimitiveParameters> StartsOf(PrimitiveKind kind, const std::vector<Solid>& known,
                                          const PointsOnGround& points) {
  std::vector<PrimitiveParameters> starts = Suggested(kind, points);
  if (IsConical(kind)) {
    for (PrimitiveParameters& x : starts) AppendSlope(0, x);
  }
  const Pose X_GM = points.X_MG.inverse(Eigen::Isometry);
  for (const Solid& solid : known) {
    const PlacedPrimitive placed{X_GM * solid.X_MS, solid.shape};
    if (auto x = ParametersOf(kind, placed)) {
      starts.push_back(*std::move(x));
    } else if (kind == PrimitiveKind::kLeaningCylinder) {
      std::ranges::move(LeaningBehind(placed), std::back_inserter(starts));
    }
  }
  if (!IsConical(kind)) return starts;
  for (std::size_t k = 0, count = starts.size(); k < count; ++k) {
    if (SlopeOf(kind, starts[k]) != 0) continue;  // a known cone keeps its slope
    starts.push_back(starts[k]);
    starts[k].tail<1>()(0) = -kStartSlope;
    starts.back().tail<1>()(0) = kStartSlope;
  }
  return starts;
}

}  // namespace cwm::perception
