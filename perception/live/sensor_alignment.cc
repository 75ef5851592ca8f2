#include "perception/live/sensor_alignment.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <tuple>
#include <utility>

#include "perception/cloud/tolerances.h"
#include "perception/live/view_planes.h"

namespace cwm::perception {
namespace {

// derived: the area over which warps are alike, 2 pi kWarpCorrelation_m^2, as a square's edge.
constexpr double kPatch_m = 0.2;
// chosen: samples of a patch; more are alike.
constexpr int kPatchSamples = 40;
// chosen: pixels of a focal length between those that are looked at: things of a hand's breadth
// have a hundred at 1 m.
constexpr double kSteps = 200;
// chosen: the reach of the search, from the errors of a pose that was measured by hand down to
// what noise and warp explain.
constexpr std::array<double, 14> kReaches_m = {0.10, 0.10, 0.10, 0.08,  0.06,  0.05, 0.04,
                                               0.03, 0.02, 0.02, 0.015, 0.015, 0.01, 0.01};
// chosen: errors of that size are looked for.
constexpr double kSearched_m = 0.05;
// chosen: half of the distance of things on a table.
constexpr double kStartShift_m = 0.06;
// chosen: the lever that turns rotations into lengths.
constexpr double kLever_m = 1;
// chosen: fewer patches or points are no view in common.
constexpr int kMinPatches = 3;
constexpr int kMinCompared = 100;
// chosen: a motion that makes so many more points lie on common surfaces is no error of normals.
constexpr double kClearlyMore = 1.05;
// chosen: a share of contradicting points that edges and mixed pixels do not reach.
constexpr double kMaxContradicting = kMinSignificantShare;
// derived: the quantile of the normal distribution beyond which 0.27 % lie, on one side.
constexpr double kQuantile_sigma = 2.782;

struct PlaneSample {
  ViewPlane plane;
  int patch = 0;
};

// The direction's face of a cube, with its sign.
int FaceOf(const Vector3& normal) {
  Eigen::Index axis = 0;
  normal.cwiseAbs().maxCoeff(&axis);
  return static_cast<int>(axis) * 2 + (normal[axis] < 0 ? 1 : 0);
}

// Samples of a view by patches of the world's grid and similar normals, at most kPatchSamples of
// each, evenly chosen.
std::vector<PlaneSample> SamplesOf(ViewPlanes& planes, int& patch_count) {
  const DepthCamera& camera = planes.view().camera;
  using Key = std::tuple<int, int, int, int>;
  std::map<Key, std::vector<ViewPlane>> patches;
  const int stride = std::max(1, static_cast<int>(camera.pinhole.focal_u_px / kSteps));
  for (int v = 0; v < camera.height; v += stride) {
    for (int u = 0; u < camera.width; u += stride) {
      const ViewPlane* const plane = planes.At(u, v);
      if (plane == nullptr) continue;
      const Eigen::Vector3i cell = (plane->p_W / kPatch_m).array().floor().cast<int>();
      patches[{cell.x(), cell.y(), cell.z(), FaceOf(plane->normal_W)}].push_back(*plane);
    }
  }
  std::vector<PlaneSample> samples;
  patch_count = 0;
  for (const auto& [key, all] : patches) {
    const double step = std::max(1.0, static_cast<double>(all.size()) / kPatchSamples);
    for (double i = 0; i < static_cast<double>(all.size()); i += step) {
      samples.push_back({all[static_cast<std::size_t>(i)], patch_count});
    }
    ++patch_count;
  }
  return samples;
}

enum class PointVerdict { kUnseen, kMatched, kContradicts };

struct Match {
  PointVerdict verdict = PointVerdict::kUnseen;
  double before_m = 0;  // along the other sensor's axis, that the point lies before its surface
  ViewPlane plane = {};
};

// The other sensor's surface in the direction of a point.
Match MatchOf(ViewPlanes& other, const Pose& X_CW, const Vector3& p_W, const Vector3& normal_W,
              double reach_m) {
  const DepthCamera& camera = other.view().camera;
  const Vector3 p_C = X_CW * p_W;
  if (p_C.z() <= camera.least_range_m) return {};
  const Pinhole& pinhole = camera.pinhole;
  const auto u =
      static_cast<int>(std::lround(pinhole.focal_u_px * p_C.x() / p_C.z() + pinhole.center_u_px));
  const auto v =
      static_cast<int>(std::lround(pinhole.focal_v_px * p_C.y() / p_C.z() + pinhole.center_v_px));
  if (u < 0 || v < 0 || u >= camera.width || v >= camera.height) return {};
  const float z = other.depth_m(u, v);
  if (z == 0) return {};
  Match match{.before_m = z - p_C.z()};
  if (match.before_m < -2 * reach_m) return match;  // hidden from the other sensor
  if (match.before_m > 2 * reach_m) {
    match.verdict = PointVerdict::kContradicts;
    return match;
  }
  const ViewPlane* const plane = other.At(u, v);
  if (plane == nullptr || plane->normal_W.dot(normal_W) < std::cos(2 * kSameNormal_rad))
    return match;
  match.plane = *plane;
  match.verdict = std::abs(plane->normal_W.dot(p_W - plane->p_W)) <= reach_m
                      ? PointVerdict::kMatched
                      : PointVerdict::kUnseen;
  return match;
}

struct NormalEquations {
  Matrix6 information = Matrix6::Zero();
  Matrix6 by_errors = Matrix6::Zero();  // the part of it that errors of normals seem to give
  Vector6 moment = Vector6::Zero();
  std::vector<Vector3> arms = {};  // of the matched points from the sensor's origin
  int patches = 0;
  int compared = 0;
  int contradicting = 0;
  std::vector<double> before_m = {};  // of what contradicts
};

NormalEquations Compare(const std::vector<PlaneSample>& samples, int patch_count,
                        const ViewPlanes& sensor, ViewPlanes& other, const Vector6& twist,
                        double reach_m) {
  const Pose X_WC = sensor.view().X_WC;
  const Pose X_WW = Moved(X_WC, twist) * X_WC.inverse();  // of points of the sensor
  const Pose X_CW = other.view().X_WC.inverse();
  std::vector<std::pair<std::size_t, ViewPlane>> matched;
  std::vector<int> counts(static_cast<std::size_t>(patch_count), 0);
  NormalEquations sums;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const ViewPlane& own = samples[i].plane;
    const Match match = MatchOf(other, X_CW, X_WW * own.p_W, X_WW.linear() * own.normal_W, reach_m);
    if (match.verdict == PointVerdict::kUnseen) continue;
    ++sums.compared;
    if (match.verdict == PointVerdict::kContradicts) {
      ++sums.contradicting;
      sums.before_m.push_back(match.before_m);
      continue;
    }
    ++counts[static_cast<std::size_t>(samples[i].patch)];
    matched.emplace_back(i, match.plane);
  }
  for (const int count : counts) sums.patches += count >= 2 ? 1 : 0;
  const double shared_m2 = sensor.SharedVariance_m2() + other.SharedVariance_m2();
  for (const auto& [i, plane] : matched) {
    const int count = counts[static_cast<std::size_t>(samples[i].patch)];
    if (count < 2) continue;  // alone it may be anything
    const Vector3 p_W = X_WW * samples[i].plane.p_W;
    const Vector3 arm = p_W - X_WC.translation();
    const double own_m2 =
        sensor.OwnVariance_m2(samples[i].plane.depth_m) + other.OwnVariance_m2(plane.depth_m);
    const double variance_m2 = shared_m2 + own_m2 / count;
    const double distance_m = plane.normal_W.dot(plane.p_W - p_W);
    // Huber's weight: what fits badly counts less.
    const double sigmas = std::abs(distance_m) / std::sqrt(shared_m2 + own_m2);
    const double weight = std::min(1.0, 2 / std::max(2.0, sigmas)) / (variance_m2 * count);
    Vector6 row;
    row << plane.normal_W, arm.cross(plane.normal_W);
    sums.information += weight * row * row.transpose();
    // Errors of normals look as if they determined motions along the surface.
    Eigen::Matrix<double, 6, 3> across;
    across.topRows<3>() = Matrix3::Identity() - plane.normal_W * plane.normal_W.transpose();
    for (int k = 0; k < 3; ++k) {
      across.block<3, 1>(3, k) = arm.cross(Vector3(across.block<3, 1>(0, k)));
    }
    sums.by_errors += weight * plane.normal_variance * across * across.transpose();
    sums.moment += weight * distance_m * row;
    sums.arms.push_back(arm);
  }
  return sums;
}

// The determined directions: their unit vectors, with rotations at the lever, and information.
struct Determined {
  Eigen::Matrix<double, 6, Eigen::Dynamic> axes;
  Eigen::VectorXd information;
};

Vector6 Scale() {
  Vector6 scale;
  scale << Vector3::Ones(), Vector3::Constant(1 / kLever_m);  // of the variables
  return scale;
}

Determined DeterminedBy(const Matrix6& information) {
  const Vector6 scale = Scale();
  const Eigen::SelfAdjointEigenSolver<Matrix6> axes(scale.asDiagonal() * information *
                                                    scale.asDiagonal());
  constexpr double kLeast = 1 / (kUndetermined_m * kUndetermined_m);
  int first = 0;
  while (first < 6 && axes.eigenvalues()[first] < kLeast) ++first;
  return {axes.eigenvectors().rightCols(6 - first), axes.eigenvalues().tail(6 - first)};
}

// Twice: the errors of normals are known by a few pixels each.
Determined DeterminedBy(const NormalEquations& sums) {
  return DeterminedBy(sums.information - 2 * sums.by_errors);
}

// The covariance, about `origin_W`, of the error of a given pose.
Matrix6 PoseCovariance(const MeanView& view, const Vector3& origin_W) {
  Matrix6 about = Matrix6::Identity();
  const Vector3 arm = origin_W - view.X_WC.translation();
  Matrix3 cross;
  cross << 0, -arm.z(), arm.y(), arm.z(), 0, -arm.x(), -arm.y(), arm.x(), 0;
  about.topRightCorner<3, 3>() = -cross;  // a turn w moves the origin by w x arm
  Vector6 sigma;
  sigma << Vector3::Constant(view.pose_sigma_m), Vector3::Constant(view.pose_sigma_rad);
  return about * Matrix6(sigma.cwiseAbs2().asDiagonal()) * about.transpose();
}

// The square of the distance of the twist from zero in standard deviations, in the directions that
// the information determines; `count` is theirs.
double SquaredDistance(const Vector6& twist, const Matrix6& information, const Matrix6& covariance,
                       int& count) {
  const Determined known = DeterminedBy(information);
  count = static_cast<int>(known.information.size());
  if (count == 0) return 0;
  const Vector6 lengths = Scale().cwiseInverse();
  const Eigen::VectorXd along = known.axes.transpose() * lengths.cwiseProduct(twist);
  Eigen::MatrixXd of_along = known.axes.transpose() *
                             (lengths.asDiagonal() * covariance * lengths.asDiagonal()) *
                             known.axes;
  of_along.diagonal() += known.information.cwiseInverse();
  return along.dot(of_along.ldlt().solve(along));
}

// The 99.73 % quantile of the chi-squared distribution (Wilson and Hilferty 1931).
double MaxSquaredDistance(int count) {
  const double part = 2.0 / (9.0 * count);
  return count * std::pow(1 - part + kQuantile_sigma * std::sqrt(part), 3);
}

double Median(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

Pose Moved(const Pose& X_WC, const Vector6& twist) {
  Pose moved = X_WC;
  moved.translation() += twist.head<3>();
  const Vector3 turn = twist.tail<3>();
  const double angle_rad = turn.norm();
  if (angle_rad > 0) {
    const Matrix3 rotation = Eigen::AngleAxisd(angle_rad, turn / angle_rad).toRotationMatrix();
    moved.linear() = Quaternion(rotation * X_WC.linear()).normalized().toRotationMatrix();
  }
  return moved;
}

Vector6 TwistBetween(const Pose& X_WC_from, const Pose& X_WC_to) {
  const Eigen::AngleAxisd turn(Matrix3(X_WC_to.linear() * X_WC_from.linear().transpose()));
  Vector6 twist;
  twist << X_WC_to.translation() - X_WC_from.translation(), turn.angle() * turn.axis();
  return twist;
}

namespace {

int CommonPoints(const NormalEquations& sums) {
  return static_cast<int>(sums.arms.size()) - sums.contradicting;
}

// Looks for the motion of a sensor from starts of its pose.
class Search {
 public:
  Search(const MeanView& sensor, const MeanView& other)
      : own_(sensor), other_(other), samples_(SamplesOf(own_, patch_count_)) {}

  NormalEquations At(const Vector6& twist, double reach_m) {
    return Compare(samples_, patch_count_, own_, other_, twist, reach_m);
  }

  // Along directions that nothing determines the errors of normals would lead the search. It keeps
  // to the others, unless it is `free`: far from the pose, surfaces that determine more may not be
  // matched yet.
  Vector6 From(Vector6 twist, std::span<const double> reaches_m, bool is_free = true) {
    const Pose& X_WC = own_.view().X_WC;
    const Vector6 scale = Scale();
    constexpr double kPrior = 1 / (kSearched_m * kSearched_m);
    for (const double reach_m : reaches_m) {
      const NormalEquations sums = At(twist, reach_m);
      Eigen::Matrix<double, 6, Eigen::Dynamic> axes = Matrix6::Identity();
      if (!is_free) axes = DeterminedBy(sums).axes;
      Eigen::MatrixXd information =
          axes.transpose() * (scale.asDiagonal() * sums.information * scale.asDiagonal()) * axes;
      information.diagonal().array() += kPrior;
      const Eigen::VectorXd moment = axes.transpose() * (scale.cwiseProduct(sums.moment) -
                                                         kPrior * twist.cwiseQuotient(scale));
      const Vector6 step = scale.cwiseProduct(Vector6(axes * information.ldlt().solve(moment)));
      twist = TwistBetween(X_WC, Moved(Moved(X_WC, twist), step));
    }
    return twist;
  }

  // The best of several starts about the twist: that with the most points on common surfaces.
  Vector6 FromAround(const Vector6& middle) {
    Vector6 best = middle;
    int most = 0;
    for (const Vector3& shift : ShiftsAround()) {
      Vector6 start = middle;
      start.head<3>() += kStartShift_m * shift;
      const Vector6 found = From(start, kReaches_m);
      const NormalEquations sums = At(found, kReaches_m.back());
      const int count = CommonPoints(sums);
      if (count <= most) continue;
      most = count;
      best = found;
    }
    return best;
  }

 private:
  static std::vector<Vector3> ShiftsAround() {
    std::vector<Vector3> shifts;
    for (const double x : {-1.0, 0.0, 1.0}) {
      for (const double y : {-1.0, 0.0, 1.0}) {
        if (x != 0 || y != 0) shifts.emplace_back(x, y, 0);
      }
    }
    return shifts;
  }

  ViewPlanes own_;
  ViewPlanes other_;
  int patch_count_ = 0;
  std::vector<PlaneSample> samples_;
};

bool IsFound(const NormalEquations& sums) {
  return sums.compared >= kMinCompared && sums.patches >= kMinPatches &&
         sums.contradicting <= kMaxContradicting * sums.compared;
}

}  // namespace

ViewAlignment AlignViews(const MeanView& sensor, const MeanView& other) {
  Search search(sensor, other);
  Vector6 twist = search.From(Vector6::Zero(), kReaches_m, /*is_free=*/false);
  NormalEquations sums = search.At(twist, kReaches_m.back());
  const Vector6 free_twist = search.From(Vector6::Zero(), kReaches_m);
  NormalEquations free_sums = search.At(free_twist, kReaches_m.back());
  if (CommonPoints(free_sums) > kClearlyMore * CommonPoints(sums)) {
    twist = free_twist;
    sums = std::move(free_sums);
  }
  if (!IsFound(sums) && sums.compared >= kMinCompared) {
    twist = search.FromAround(Vector6::Zero());
    sums = search.At(twist, kReaches_m.back());
  }
  ViewAlignment alignment;
  alignment.compared = sums.compared;
  alignment.patches = sums.patches;
  if (sums.compared < kMinCompared) return alignment;
  alignment.contradicting = static_cast<double>(sums.contradicting) / sums.compared;
  if (!IsFound(sums)) {
    alignment.apart_m = Median(std::move(sums.before_m));
    return alignment;
  }
  const Determined known = DeterminedBy(sums);
  const Vector6 scale = Scale();
  const Vector6 lengths = scale.cwiseInverse();
  alignment.is_aligned = true;
  alignment.determined = static_cast<int>(known.information.size());
  alignment.twist =
      scale.cwiseProduct(known.axes * (known.axes.transpose() * lengths.cwiseProduct(twist)));
  alignment.information =
      lengths.asDiagonal() *
      Matrix6(known.axes * known.information.asDiagonal() * known.axes.transpose()) *
      lengths.asDiagonal();
  double squares = 0;
  for (const Vector3& arm : sums.arms) {
    squares += (alignment.twist.head<3>() + alignment.twist.tail<3>().cross(arm)).squaredNorm();
  }
  alignment.apart_m = std::sqrt(squares / static_cast<double>(sums.arms.size()));
  return alignment;
}

ViewAlignment Reversed(const ViewAlignment& alignment, const MeanView& sensor,
                       const MeanView& other) {
  ViewAlignment reversed = alignment;
  // The opposite motion of the space, about the other sensor's origin.
  const Vector3 arm = other.X_WC.translation() - sensor.X_WC.translation();
  Matrix3 cross;
  cross << 0, -arm.z(), arm.y(), arm.z(), 0, -arm.x(), -arm.y(), arm.x(), 0;
  Matrix6 about = Matrix6::Identity();
  about.topRightCorner<3, 3>() = -cross;
  reversed.twist = -about * alignment.twist;
  Matrix6 back = Matrix6::Identity();
  back.topRightCorner<3, 3>() = cross;
  reversed.information = back.transpose() * alignment.information * back;
  return reversed;
}

ViewAlignment WithOtherMoved(const ViewAlignment& alignment, const MeanView& sensor,
                             const Pose& X_WW) {
  ViewAlignment moved = alignment;
  moved.twist = TwistBetween(sensor.X_WC, X_WW * Moved(sensor.X_WC, alignment.twist));
  return moved;
}

bool Contradicts(const ViewAlignment& alignment, const MeanView& sensor, const MeanView& other) {
  if (!alignment.is_aligned) return alignment.contradicting > kMaxContradicting;
  const Vector3& origin_W = sensor.X_WC.translation();
  int count = 0;
  const double squared =
      SquaredDistance(alignment.twist, alignment.information,
                      PoseCovariance(sensor, origin_W) + PoseCovariance(other, origin_W), count);
  return count > 0 && squared > MaxSquaredDistance(count);
}

Pose MostLikelyPose(const MeanView& sensor, std::span<const ViewAlignment> alignments) {
  Matrix6 information = PoseCovariance(sensor, sensor.X_WC.translation()).inverse();
  Vector6 moment = Vector6::Zero();
  for (const ViewAlignment& each : alignments) {
    if (!each.is_aligned) continue;
    information += each.information;
    moment += each.information * each.twist;
  }
  return Moved(sensor.X_WC, information.ldlt().solve(moment));
}

std::optional<SensorPoseEstimate> EstimatePose(const MeanView& sensor,
                                               std::span<const ViewAlignment> alignments,
                                               std::optional<Vector6>* undetermined) {
  // The alignment that agrees best with the other ones and with the given pose.
  const Matrix6 given = PoseCovariance(sensor, sensor.X_WC.translation());
  const auto distance_of = [&](const Vector6& difference, const Matrix6& information) {
    int count = 0;
    const double squared = SquaredDistance(difference, information, given, count);
    return count == 0 ? 0 : std::min(1.0, squared / MaxSquaredDistance(count));
  };
  const ViewAlignment* best = nullptr;
  double least = 0;
  for (const ViewAlignment& candidate : alignments) {
    if (!candidate.is_aligned) continue;
    double sum = 0.5 * distance_of(candidate.twist, candidate.information);
    for (const ViewAlignment& each : alignments) {
      if (each.is_aligned) sum += distance_of(each.twist - candidate.twist, each.information);
    }
    if (best != nullptr && sum >= least) continue;
    best = &candidate;
    least = sum;
  }
  if (best == nullptr) return std::nullopt;
  SensorPoseEstimate estimate;
  Matrix6 information = Matrix6::Zero();
  Vector6 moment = Vector6::Zero();
  for (const ViewAlignment& each : alignments) {
    if (!each.is_aligned || distance_of(each.twist - best->twist, each.information) >= 1) continue;
    information += each.information;
    moment += each.information * each.twist;
    estimate.patches += each.patches;
  }
  const Vector6 scale = Scale();
  const Eigen::SelfAdjointEigenSolver<Matrix6> axes(scale.asDiagonal() * information *
                                                    scale.asDiagonal());
  if (axes.eigenvalues()[0] < 1 / (kUndetermined_m * kUndetermined_m)) {
    if (undetermined != nullptr) *undetermined = scale.cwiseProduct(axes.eigenvectors().col(0));
    return std::nullopt;
  }
  const Matrix6 covariance = information.inverse();
  const Vector6 twist = covariance * moment;
  estimate.X_WC = Moved(sensor.X_WC, twist);
  estimate.translation_error_m = twist.head<3>().norm();
  estimate.rotation_error_rad = twist.tail<3>().norm();
  const auto sigma = [](const Matrix3& block) {
    return std::sqrt(Eigen::SelfAdjointEigenSolver<Matrix3>(block).eigenvalues()[2]);
  };
  estimate.sigma_m = sigma(covariance.topLeftCorner<3, 3>());
  estimate.sigma_rad = sigma(covariance.bottomRightCorner<3, 3>());
  return estimate;
}

}  // namespace cwm::perception
