#include "perception/solids/plane_solid.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "collision/geometry/coefficients.h"
#include "collision/geometry/polygon.h"
#include "perception/cloud/quantile.h"
#include "perception/cloud/tolerances.h"
#include "perception/solids/box_solid.h"
#include "perception/solids/free_space.h"
#include "perception/solids/observed.h"
#include "perception/solids/solid_assembly.h"

namespace cwm::perception {
namespace {

// measured: the least share of a rectangle's outline that the hull shares if the rest is occluded;
// round lids would share 0.2 to 0.46, the faces of eight boxes share 0.56 to 0.66. Also the least
// share of a hull that its points fill, which an L does not, and that is above the ground.
constexpr double kMinOutline = 0.55;
// chosen: that share where no ray can tell whether the rest is empty.
constexpr double kMinFillWithoutRays = 0.85;
// derived: six points per cell on average, so chance leaves one cell in 500 empty.
constexpr double kFillSpacings = 2.5;

// chosen: the least share of the smallest rectangle that the outline of a box's face fills; a disc
// fills 0.79.
constexpr double kRectangleFill = 0.85;
// chosen: the least sine of the angle between a side behind the face and the ray to it, 6 degrees.
constexpr double kMinSide_sin = 0.1;

Rectangle BoundsAlong(const Polygon& hull, const Vector2& x) {
  Rectangle r{x, {}};
  for (const Vector2& p : hull) r.bounds.extend(Vector2(x.dot(p), x.x() * p.y() - x.y() * p.x()));
  return r;
}

double FilledArea_m2(const std::vector<Vector2>& points, double cell_m) {
  std::set<std::pair<long, long>> cells;
  for (const Vector2& p : points) {
    cells.emplace(std::lround(p.x() / cell_m), std::lround(p.y() / cell_m));
  }
  return static_cast<double>(cells.size()) * cell_m * cell_m;
}

// The depth of the solid behind the face if no side of it is seen, in metres.
double Thickness_m(const PlaneModel& plane, const Ground& ground) {
  if (!ground.known || plane.normal.dot(ground.up) < std::cos(kSameDirection_rad)) {
    return kLoneThickness_m;
  }
  const double height_m = ground.Height_m(plane.point);
  return height_m > 0 && height_m < kLowLevel_m ? height_m : kLoneThickness_m;
}

// Moves the lower side of an upright face to the ground if it ends just above it, or below it.
void StandOnGround(const Matrix3& face, const PlaneModel& plane, const Ground& ground,
                   Eigen::AlignedBox2d& bounds) {
  for (int k = 0; k < 2; ++k) {
    const double up = face.col(k).dot(ground.up);
    if (!ground.known || std::abs(up) < std::cos(kSameDirection_rad)) continue;
    const double ground_m = -ground.Height_m(plane.point) / up;
    if (up > 0 && bounds.min()(k) < ground_m + kStandingGap_m) bounds.min()(k) = ground_m;
    if (up < 0 && bounds.max()(k) > ground_m - kStandingGap_m) bounds.max()(k) = ground_m;
  }
}

// Points behind a face that lie on one side of its box.
struct Side {
  std::vector<double> across_m;
  std::map<long, std::vector<double>> depths_m;  // by cell along the side

  // The median over the cells of the deepest point. Another object that continues the side over
  // part of its length does not change it.
  double Depth_m() const {
    std::vector<double> deepest_m;
    for (const auto& [cell, depths] : depths_m) {
      deepest_m.push_back(*std::ranges::max_element(depths));
    }
    return Quantile(std::move(deepest_m), 0.5);
  }
};

// How far points extend behind a face on those sides of its box that face the sensor, in metres; 0
// if they cover less than half the length of every side. Moves the bounds to the sides that are
// found. A side seen at a slant is narrower than the window that normals are estimated in, so it is
// no face of its own; its points are no mixed pixels either, since those lie behind edges whose
// other side is hidden.
double SeenDepth_m(const Matrix3& face, const PlaneModel& plane, const ModelPoints& points,
                   Eigen::AlignedBox2d& bounds) {
  const double cell_m = kFillSpacings * points.spacing_m;
  const auto points_on = [&](int across, double at_m) {
    Side side;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Vector3 x = points.p[i] - plane.point;
      const double depth_m = -plane.normal.dot(x), across_m = face.col(across).dot(x);
      const double along_m = face.col(1 - across).dot(x);
      if (depth_m <= points.gate_m[i] || along_m < bounds.min()(1 - across) ||
          along_m > bounds.max()(1 - across) || std::abs(across_m - at_m) > points.gate_m[i]) {
        continue;
      }
      side.across_m.push_back(across_m);
      side.depths_m[std::lround(along_m / cell_m)].push_back(depth_m);
    }
    return side;
  };
  double depth_m = 0;
  for (int k = 0; k < 4; ++k) {
    const int across = k / 2;
    double& bound_m = k % 2 == 0 ? bounds.min()(across) : bounds.max()(across);
    Vector2 middle = bounds.center();
    middle(across) = bound_m;
    const Vector3 outward = (k % 2 == 0 ? -1 : 1) * face.col(across);
    const Vector3 to_sensor = points.viewpoint - plane.point - face.leftCols<2>() * middle;
    if (outward.dot(to_sensor) < kMinSide_sin * to_sensor.norm()) continue;
    Side side = points_on(across, bound_m);
    if (side.across_m.empty()) continue;
    side = points_on(across, Quantile(std::move(side.across_m), 0.5));  // edges are rounded
    const double covered_m = static_cast<double>(side.depths_m.size()) * cell_m;
    if (covered_m < kMajority * bounds.sizes()(1 - across)) continue;
    bound_m = Quantile(std::move(side.across_m), 0.5);
    depth_m = std::max(depth_m, side.Depth_m());
  }
  return depth_m;
}

Solid BoxBehind(const Matrix3& face, const PlaneModel& plane, const Eigen::AlignedBox2d& bounds,
                double thickness_m) {
  const Vector3 size(bounds.sizes().x(), bounds.sizes().y(), thickness_m);
  const Vector2 middle = bounds.center();
  Solid solid;
  solid.X_MS.linear() = CanonicalBoxAxes(face);
  solid.X_MS.translation() = plane.point + middle.x() * face.col(0) + middle.y() * face.col(1) -
                             0.5 * thickness_m * plane.normal;
  // The sizes are permuted with their axes.
  solid.shape = Box{.size_m = (solid.X_MS.linear().transpose() * face).cwiseAbs() * size};
  return solid;
}

// The part of a convex outline in the face that is not below the ground.
Polygon AboveGround(const Polygon& hull, const Matrix3& face, const PlaneModel& plane,
                    const Ground& ground) {
  const auto height_m = [&](const Vector2& p) {
    return ground.Height_m(plane.point + face.leftCols<2>() * p);
  };
  Polygon above;
  for (std::size_t k = 0; k < hull.size(); ++k) {
    const Vector2 &p = hull[k], &next = hull[(k + 1) % hull.size()];
    const double at_m = height_m(p), next_m = height_m(next);
    if (at_m >= 0) above.push_back(p);
    if ((at_m < 0) != (next_m < 0)) above.emplace_back(p + at_m / (at_m - next_m) * (next - p));
  }
  return ConvexHull(std::move(above));
}

std::vector<double> PlaneSigmas(const ShapeFit& fit, const PlaneModel& plane,
                                const Vector3& origin_L) {
  if (fit.covariance.rows() != PlaneModel::kParameterCount) return {};
  // The normal changes with the two tilts; d = -n . p changes with them and with the shift along
  // the normal.
  const Matrix3 basis = BasisFromZ(plane.normal);
  Eigen::Matrix<double, 4, 3> jacobian;
  jacobian.topLeftCorner<3, 2>() = basis.leftCols<2>();
  jacobian.topRightCorner<3, 1>().setZero();
  const Vector3 point_L = origin_L + plane.point;
  jacobian.row(3) << -basis.col(0).dot(point_L), -basis.col(1).dot(point_L), -1;
  const Eigen::Vector4d variance = (jacobian * fit.covariance * jacobian.transpose()).diagonal();
  std::vector<double> sigma;
  for (double v : variance) sigma.push_back(std::sqrt(std::max(0.0, v)));
  return sigma;
}

Solid PlateBehind(const Matrix3& face, const ShapeFit& fit, Polygon outline, double thickness_m,
                  const FitContext& context) {
  const auto& plane = std::get<PlaneModel>(fit.model);
  Solid solid;
  solid.X_MS.linear() = face;
  solid.X_MS.translation() = plane.point;
  solid.shape = Plate{.outline = std::move(outline), .holes = {}, .thickness_m = thickness_m};
  solid.parameter_sigma = PlaneSigmas(fit, plane, context.points.origin_L);
  return solid;
}

// True if more rays pass the solid behind the face than mixed pixels explain: rays to what is
// beside and behind the object, or to the object's own points behind the face. The occluder of a
// face lets no more rays than that through.
bool IsRunThrough(const Solid& solid, const PlaneModel& plane, const FitContext& c) {
  if (CrossingRayShare(solid, c.free) > kMaxPassing) return true;
  if (!c.options.from_viewpoint) return false;
  const Pose X_SM = solid.X_MS.inverse(Eigen::Isometry);
  std::size_t behind = 0, on = 0;
  for (std::uint32_t i = 0; i < c.points.size(); ++i) {
    const Vector3& p = c.points.p[i];
    const double off_m = plane.Distance_m(p), gate_m = c.points.gate_m[i];
    on += std::abs(off_m) <= gate_m;
    if (off_m >= -gate_m || std::abs(SignedDistance_m(solid, X_SM * p)) <= gate_m) continue;
    behind += EntersSolid(solid, c.points.viewpoint, p);
  }
  return static_cast<double>(behind) > kMaxPassing * static_cast<double>(on);
}

// True if rays pass the solid, or if there are no rays that could tell.
bool IsOpen(const Solid& solid, const PlaneModel& plane, const FitContext& c) {
  return c.free.rays.empty() || IsRunThrough(solid, plane, c);
}

// The share of the rectangle's outline that the hull follows within a tolerance.
double SharedOutline(const Polygon& hull, const Rectangle& rectangle, double tolerance_m) {
  const Vector2 y(-rectangle.x.y(), rectangle.x.x());
  const auto inside_m = [&](const Vector2& p) {  // distances from the four sides, positive inside
    const Vector2 at(rectangle.x.dot(p), y.dot(p));
    Eigen::Vector4d inside;
    inside << at - rectangle.bounds.min(), rectangle.bounds.max() - at;
    return inside;
  };
  double shared_m = 0;
  for (std::size_t k = 0; k < hull.size(); ++k) {
    const Vector2 &p = hull[k], &next = hull[(k + 1) % hull.size()];
    const Eigen::Vector4d farther_m = inside_m(p).cwiseMax(inside_m(next));
    if (farther_m.minCoeff() <= tolerance_m) shared_m += (next - p).norm();
  }
  return shared_m / (2 * rectangle.bounds.sizes().sum());
}

// Returns the rectangle that shares most of its outline with the hull, if it is at least
// kMinOutline and the hull fills half of it: the hull may be what an occluder leaves of the
// rectangle.
std::optional<Rectangle> PartlyHiddenRectangle(const Polygon& hull, double tolerance_m) {
  std::optional<Rectangle> best;
  double max_shared = kMinOutline;
  for (std::size_t k = 0; k < hull.size(); ++k) {
    const Vector2 edge = hull[(k + 1) % hull.size()] - hull[k];
    if (!(edge.norm() > 0)) continue;
    const Rectangle r = BoundsAlong(hull, edge.normalized());
    const double shared = SharedOutline(hull, r, tolerance_m);
    if (shared > max_shared) best = r, max_shared = shared;
  }
  if (best && SignedArea_m2(hull) < kMajority * best->area_m2()) return std::nullopt;
  return best;
}

// Returns the box behind the rectangle; empty if it would have no size.
std::optional<Solid> BoxOver(const Rectangle& rectangle, const Matrix3& face, const ShapeFit& fit,
                             double thickness_m, const FitContext& context, const Ground& ground) {
  const auto& plane = std::get<PlaneModel>(fit.model);
  Matrix3 along = face;
  along.col(0) = rectangle.x.x() * face.col(0) + rectangle.x.y() * face.col(1);
  along.col(1) = plane.normal.cross(along.col(0));
  Eigen::AlignedBox2d bounds;
  for (int k = 0; k < 2; ++k) {
    const Interval extent = ExtentAlong(along.col(k), context.points, fit.covered);
    const double at_m = along.col(k).dot(plane.point);
    bounds.min()(k) = extent.low_m - at_m;
    bounds.max()(k) = extent.high_m - at_m;
  }
  StandOnGround(along, plane, ground, bounds);
  if (!(bounds.sizes().minCoeff() > 0)) return std::nullopt;
  Solid thin = BoxBehind(along, plane, bounds, thickness_m);
  double depth_m = SeenDepth_m(along, plane, context.points, bounds);
  if (depth_m <= thickness_m) return thin;
  if (ground.known && plane.normal.dot(ground.up) > std::cos(kSameDirection_rad)) {
    const double height_m = ground.Height_m(plane.point);
    if (std::abs(height_m - depth_m) < kStandingGap_m) depth_m = height_m;
  }
  Solid deep = BoxBehind(along, plane, bounds, depth_m);
  deep.inliers = fit.inliers;
  // If points on the far side are seen from within, the box is open.
  return IsRunThrough(deep, plane, context) || IsCrossed(deep, context) ? thin : deep;
}

}  // namespace

bool IsLoneFace(const Shape& shape) {
  const auto* box = std::get_if<Box>(&shape);
  // The sizes were rotated to the box's axes and have rounding errors.
  return box != nullptr &&
         static_cast<float>(box->size_m.minCoeff()) <= static_cast<float>(kLoneThickness_m);
}

Rectangle SmallestRectangle(const Polygon& hull) {
  Rectangle best;
  double min_area_m2 = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < hull.size(); ++k) {
    const Vector2 edge = hull[(k + 1) % hull.size()] - hull[k];
    if (!(edge.norm() > 0)) continue;
    const Rectangle r = BoundsAlong(hull, edge.normalized());
    if (r.area_m2() < min_area_m2) best = r, min_area_m2 = r.area_m2();
  }
  return best;
}

std::optional<Solid> MakePlaneSolid(const ShapeFit& fit, const FitContext& context,
                                    const Ground& ground) {
  const auto& plane = std::get<PlaneModel>(fit.model);
  Matrix3 face = BasisFromZ(plane.normal);
  std::vector<Vector2> flat;
  for (std::uint32_t i : fit.covered) {
    const Vector3 x = context.points.p[i] - plane.point;
    flat.emplace_back(face.col(0).dot(x), face.col(1).dot(x));
  }
  const Polygon hull = ConvexHull(flat);
  if (hull.size() < 3) return std::nullopt;
  const double hull_area = SignedArea_m2(hull);
  const double thickness_m = Thickness_m(plane, ground);
  const double filled_m2 = FilledArea_m2(flat, kFillSpacings * context.points.spacing_m);
  const double min_fill = context.options.from_viewpoint ? kMinOutline : kMinFillWithoutRays;
  const bool is_filled = filled_m2 >= min_fill * hull_area;  // a thin L is not filled
  Solid solid = PlateBehind(face, fit, hull, thickness_m, context);
  if (!is_filled && IsOpen(solid, plane, context)) return std::nullopt;
  const Rectangle smallest = SmallestRectangle(hull);
  if (hull_area >= kRectangleFill * smallest.area_m2()) {
    std::optional<Solid> box = BoxOver(smallest, face, fit, thickness_m, context, ground);
    if (!box) return std::nullopt;
    solid = *std::move(box);
  } else if (const auto hidden = PartlyHiddenRectangle(hull, context.points.spacing_m)) {
    std::optional<Solid> box = BoxOver(*hidden, face, fit, thickness_m, context, ground);
    if (box && !IsOpen(*box, plane, context)) {
      solid = *std::move(box);
      solid.role = PartRole::kCompleted;
    }
  }
  // The body behind a level face may reach into the ground, but the face itself may not.
  const double behind_m = thickness_m * std::max(0.0, plane.normal.dot(ground.up));
  if (ground.known && LowestHeight_m(solid, ground) < -kGroundNoise_m - behind_m) {
    Polygon above = AboveGround(hull, face, plane, ground);
    if (above.size() < 3 || SignedArea_m2(above) < kMinOutline * hull_area) return std::nullopt;
    solid = PlateBehind(face, fit, std::move(above), thickness_m, context);
  }
  solid.inliers = fit.inliers;
  return solid;
}

}  // namespace cwm::perception
