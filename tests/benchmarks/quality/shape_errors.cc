#include "tests/benchmarks/quality/shape_errors.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "collision/geometry/signed_distance.h"

namespace cwm::benchmarks {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// The measured points of a true shape moved onto its surface, in its frame.
std::vector<Vector3> SeenSurface_S(const TrueShape& truth, const InterpretedView& view) {
  const Pose X_SW = truth.X_WS.inverse();
  std::vector<Vector3> seen;
  seen.reserve(truth.points.size());
  for (std::uint32_t i : truth.points) {
    seen.push_back(NearestSurfacePoint(truth.shape, X_SW * PointInWorld(view, i)).nearest);
  }
  return seen;
}

double MeanDepth_m(const TrueShape& truth, const InterpretedView& view) {
  double sum_m = 0;
  for (std::uint32_t i : truth.points) sum_m += view.scan.cloud.points[i].z();
  return sum_m / static_cast<double>(truth.points.size());
}

using AxisFlags = std::array<bool, 3>;

// The axes of the shape's own frame along which both ends were seen.
AxisFlags BothEndsSeen(const TrueShape& truth, const InterpretedView& view) {
  const Vector3 half_m = 0.5 * TightBounds(truth.shape, Pose::Identity()).sizes();
  const double near_m = kEndSeen_px * MeanDepth_m(truth, view) / view.camera.focal_px;
  std::array<int, 3> low = {}, high = {};
  for (const Vector3& p_S : SeenSurface_S(truth, view)) {
    for (std::size_t a = 0; a < 3; ++a) {
      const auto axis = static_cast<Eigen::Index>(a);
      low[a] += p_S[axis] < near_m - half_m[axis];
      high[a] += p_S[axis] > half_m[axis] - near_m;
    }
  }
  AxisFlags both = {};
  for (std::size_t a = 0; a < 3; ++a) both[a] = std::min(low[a], high[a]) >= kEndSeenPoints;
  return both;
}

bool HasAxis(const Shape& shape) {
  return KindOf(shape) == ShapeKind::kCylinder || KindOf(shape) == ShapeKind::kCone;
}

double Length_m(const Shape& shape) {
  if (const auto* cylinder = std::get_if<Cylinder>(&shape)) return cylinder->length_m;
  return std::get<Cone>(shape).length_m;
}

// The angle by which the radius grows along z.
double HalfAngle_rad(const Shape& shape) {
  const auto* cone = std::get_if<Cone>(&shape);
  if (cone == nullptr) return 0;
  return std::atan2(cone->radius_top_m - cone->radius_bottom_m, cone->length_m);
}

double LineAngle_rad(const Vector3& a, const Vector3& b) {
  return std::atan2(a.cross(b).norm(), std::abs(a.dot(b)));
}

// The errors of a cylinder or cone against another: quantities that both have.
ShapeErrors RoundErrors(const TrueShape& truth, const FoundShape& found,
                        const InterpretedView& view) {
  const Vector3 axis_W = truth.X_WS.linear().col(2), found_axis_W = found.X_WS.linear().col(2);
  const Vector3 middle_S(0, 0, MiddleOfSeen_S(truth, view).z());
  const double z_found_m = (found.X_WS.inverse() * (truth.X_WS * middle_S)).z();
  const double turn = axis_W.dot(found_axis_W) < 0 ? -1 : 1;
  ShapeErrors errors;
  errors.radius_m =
      std::abs(*RadiusAt_m(found.part.shape, z_found_m) - *RadiusAt_m(truth.shape, middle_S.z()));
  errors.axis_rad = LineAngle_rad(axis_W, found_axis_W);
  if (KindOf(truth.shape) == ShapeKind::kCone) {
    errors.half_angle_rad =
        std::abs(turn * HalfAngle_rad(found.part.shape) - HalfAngle_rad(truth.shape));
  }
  if (BothEndsSeen(truth, view)[2]) {
    errors.length_m = {std::abs(Length_m(found.part.shape) - Length_m(truth.shape))};
    errors.centre_m = (found.X_WS.translation() - truth.X_WS.translation()).norm();
  } else {
    const Vector3 on_found_axis_S = truth.X_WS.inverse() * (found.X_WS * Vector3(0, 0, z_found_m));
    errors.centre_m = (on_found_axis_S - middle_S).head<2>().norm();
  }
  return errors;
}

// The found box's axis that runs along each of the true one's.
std::array<Eigen::Index, 3> PairedAxes(const Matrix3& R_SF) {
  std::array<Eigen::Index, 3> order = {0, 1, 2}, best = order;
  double best_sum = -1;
  do {
    double sum = 0;
    for (Eigen::Index a = 0; a < 3; ++a)
      sum += std::abs(R_SF(a, order[static_cast<std::size_t>(a)]));
    if (sum > best_sum) best = order, best_sum = sum;
  } while (std::next_permutation(order.begin(), order.end()));
  return best;
}

// The sizes of the found shape along the true box's axes: its edges if it is a box, else its
// bounds.
struct BoxComparison {
  Vector3 size_m;
  double axis_rad = 0;
  Vector3 centre_S;
};

BoxComparison AlongTrueBox(const TrueShape& truth, const FoundShape& found) {
  const Pose X_SF = truth.X_WS.inverse() * found.X_WS;
  const auto* box = std::get_if<Box>(&found.part.shape);
  if (box == nullptr) {
    const Aabb bounds = TightBounds(found.part.shape, X_SF);
    return {.size_m = bounds.sizes(), .axis_rad = kInfinity, .centre_S = bounds.center()};
  }
  const std::array<Eigen::Index, 3> pairs = PairedAxes(X_SF.linear());
  BoxComparison result{.size_m = {}, .centre_S = X_SF.translation()};
  for (std::size_t a = 0; a < 3; ++a) {
    const auto axis = static_cast<Eigen::Index>(a);
    result.size_m[axis] = box->size_m[pairs[a]];
    result.axis_rad =
        std::max(result.axis_rad, LineAngle_rad(Vector3::Unit(axis), X_SF.linear().col(pairs[a])));
  }
  return result;
}

ShapeErrors BoxErrors(const TrueShape& truth, const FoundShape& found,
                      const InterpretedView& view) {
  const BoxComparison compared = AlongTrueBox(truth, found);
  const AxisFlags both_ends = BothEndsSeen(truth, view);
  ShapeErrors errors;
  errors.box_axis_rad = compared.axis_rad;
  double square = 0;
  for (std::size_t a = 0; a < 3; ++a) {
    if (!both_ends[a]) continue;
    const auto axis = static_cast<Eigen::Index>(a);
    errors.length_m.push_back(
        std::abs(compared.size_m[axis] - std::get<Box>(truth.shape).size_m[axis]));
    square += compared.centre_S[axis] * compared.centre_S[axis];
  }
  if (!errors.length_m.empty()) errors.centre_m = std::sqrt(square);
  return errors;
}

}  // namespace

std::optional<double> RadiusAt_m(const Shape& shape, double z_m) {
  if (const auto* sphere = std::get_if<Sphere>(&shape)) return sphere->radius_m;
  if (const auto* cylinder = std::get_if<Cylinder>(&shape)) return cylinder->radius_m;
  if (const auto* cone = std::get_if<Cone>(&shape)) {
    return std::lerp(cone->radius_bottom_m, cone->radius_top_m, z_m / cone->length_m + 0.5);
  }
  return std::nullopt;
}

Vector3 MiddleOfSeen_S(const TrueShape& truth, const InterpretedView& view) {
  Vector3 sum = Vector3::Zero();
  for (const Vector3& p_S : SeenSurface_S(truth, view)) sum += p_S;
  return sum / static_cast<double>(truth.points.size());
}

ShapeErrors ErrorsOf(const TrueShape& truth, const FoundShape& found, const InterpretedView& view) {
  if (KindOf(truth.shape) == ShapeKind::kBox) return BoxErrors(truth, found, view);
  if (HasAxis(truth.shape) && HasAxis(found.part.shape)) return RoundErrors(truth, found, view);
  if (KindOf(truth.shape) == ShapeKind::kSphere) {
    const auto radius_m = RadiusAt_m(found.part.shape, 0);
    if (KindOf(found.part.shape) != ShapeKind::kSphere) return InfiniteErrors(truth, view);
    ShapeErrors errors;
    errors.radius_m = std::abs(*radius_m - std::get<Sphere>(truth.shape).radius_m);
    errors.centre_m = (found.X_WS.translation() - truth.X_WS.translation()).norm();
    return errors;
  }
  return InfiniteErrors(truth, view);
}

ShapeErrors InfiniteErrors(const TrueShape& truth, const InterpretedView& view) {
  const FoundShape itself{.X_WS = truth.X_WS, .part = {.shape = truth.shape}};
  ShapeErrors errors = ErrorsOf(truth, itself, view);
  const auto lose = [](std::optional<double>& error) {
    if (error) error = kInfinity;
  };
  for (auto* error : {&errors.radius_m, &errors.axis_rad, &errors.half_angle_rad,
                      &errors.box_axis_rad, &errors.centre_m}) {
    lose(*error);
  }
  for (double& error : errors.length_m) error = kInfinity;
  return errors;
}

double SurfaceDifference_m(const TrueShape& truth, const FoundShape& found,
                           const InterpretedView& view) {
  const Pose X_FS = found.X_WS.inverse() * truth.X_WS;
  double squares = 0;
  for (const Vector3& p_S : SeenSurface_S(truth, view)) {
    const double distance_m = SignedDistance_m(found.part.shape, X_FS * p_S);
    squares += distance_m * distance_m;
  }
  return std::sqrt(squares / static_cast<double>(truth.points.size()));
}

}  // namespace cwm::benchmarks
