#include "perception/track/alignment.h"
#include "perception/cloud/decompositions.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace cwm::perception {
namespace {

constexpr int kAlignmentSteps = 20;  // chosen: seven steps shrink the gate, the others converge
constexpr double kGateShrink = 0.8;  // chosen: per step, from 30 mm to 6 mm in seven
// chosen: steps below a hundredth of the noise of the best sensor change nothing.
constexpr double kConverged_m = 1e-5;
// chosen: the damping as a share of the total weight of all points in one direction. A direction
// that less than a thousandth of them determine moves slowly, so that noise does not turn a can.
constexpr double kDamping = 0.001;
// chosen: the error of a predicted turn as a share of that of a predicted shift.
constexpr double kTurnShare = 0.25;

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

struct Normals {
  Matrix6 information = Matrix6::Zero();
  Vector6 pull = Vector6::Zero();
  double weight = 0;
};

struct Lever {
  Vector3 center_L = Vector3::Zero();
  double length_m = 1;  // makes rotations comparable to translations
};

Lever LeverOf(const std::vector<Eigen::Vector3f>& points_L) {
  Lever lever;
  for (const Eigen::Vector3f& p : points_L) lever.center_L += p.cast<double>();
  lever.center_L /= static_cast<double>(points_L.size());
  double squares = 0;
  for (const Eigen::Vector3f& p : points_L) {
    squares += (p.cast<double>() - lever.center_L).squaredNorm();
  }
  lever.length_m = std::max(0.001, std::sqrt(squares / static_cast<double>(points_L.size())));
  return lever;
}

Normals Linearise(const std::vector<Eigen::Vector3f>& points_L, const ModelSurface& surface,
                  const Pose& X_LO, const Lever& lever, double gate_m) {
  Normals sums;
  const Pose X_OL = X_LO.inverse();
  for (const Eigen::Vector3f& point : points_L) {
    const Vector3 p_L = point.cast<double>();
    const auto nearest = surface.Nearest(X_OL * p_L, gate_m);
    if (!nearest || std::abs(nearest->signed_distance_m) >= gate_m) continue;
    const double share = nearest->signed_distance_m / gate_m;
    const double weight = (1 - share * share) * (1 - share * share);  // Tukey's biweight
    const Vector3 normal_L = X_LO.linear() * nearest->normal;
    Vector6 row;  // the derivative of the distance by translation and by rotation about the centre
    row << normal_L, (p_L - lever.center_L).cross(normal_L) / lever.length_m;
    sums.information += weight * row * row.transpose();
    sums.pull += weight * nearest->signed_distance_m * row;
    sums.weight += weight;
  }
  return sums;
}

Pose Moved(const Pose& X_LO, const Vector6& step, const Lever& lever) {
  const Vector3 turn = step.tail<3>() / lever.length_m;
  const double angle_rad = turn.norm();
  Pose moved = X_LO;
  moved.translation() += step.head<3>();
  if (angle_rad == 0) return moved;
  const Matrix3 rotation = Eigen::AngleAxisd(angle_rad, turn / angle_rad).toRotationMatrix();
  const Vector3 arm = X_LO.translation() - lever.center_L;
  moved.translation() = lever.center_L + rotation * arm + step.head<3>();
  // A normalised quaternion keeps rounding errors from accumulating.
  moved.linear() = Quaternion(rotation * X_LO.linear()).normalized().toRotationMatrix();
  return moved;
}

}  // namespace

double MeanDistance_m(const std::vector<Eigen::Vector3f>& points_L, const ModelSurface& surface,
                      const Pose& X_LO) {
  const Pose X_OL = X_LO.inverse();
  double sum_m = 0;
  for (const Eigen::Vector3f& p : points_L) {
    const auto nearest = surface.Nearest(X_OL * p.cast<double>(), kAlignmentReach_m);
    const double distance_m = nearest ? std::abs(nearest->signed_distance_m) : kAlignmentReach_m;
    sum_m += std::min(distance_m, kAlignmentReach_m);
  }
  return sum_m / static_cast<double>(points_L.size());
}

namespace {

enum class Freedom { kTranslation, kAll };

Pose AlignWith(const std::vector<Eigen::Vector3f>& points_L, const ModelSurface& surface,
               const Pose& X_LO_guess, double gate_m, double first_gate_m, Freedom freedom) {
  if (points_L.empty()) return X_LO_guess;
  const Lever lever = LeverOf(points_L);
  Pose X_LO = X_LO_guess;
  double current_gate_m = std::max(gate_m, first_gate_m);
  for (int i = 0; i < kAlignmentSteps; ++i) {
    const Normals sums = Linearise(points_L, surface, X_LO, lever, current_gate_m);
    if (!(sums.weight > 0)) return X_LO;
    const Matrix6 damped = sums.information + kDamping * sums.weight * Matrix6::Identity();
    Vector6 step = Vector6::Zero();
    if (freedom == Freedom::kAll) {
      step = SolveSymmetric(damped, sums.pull);
    } else {
      step.head<3>() = damped.topLeftCorner<3, 3>().ldlt().solve(sums.pull.head<3>());
    }
    X_LO = Moved(X_LO, step, lever);
    if (current_gate_m <= gate_m && step.norm() < kConverged_m) return X_LO;
    current_gate_m = std::max(gate_m, kGateShrink * current_gate_m);
  }
  return X_LO;
}

}  // namespace

Pose Align(const std::vector<Eigen::Vector3f>& points_L, const ModelSurface& surface,
           const Pose& X_LO_guess, double gate_m, double first_gate_m) {
  return AlignWith(points_L, surface, X_LO_guess, gate_m, first_gate_m, Freedom::kAll);
}

Pose AlignTranslation(const std::vector<Eigen::Vector3f>& points_L, const ModelSurface& surface,
                      const Pose& X_LO_guess, double gate_m, double first_gate_m) {
  return AlignWith(points_L, surface, X_LO_guess, gate_m, first_gate_m, Freedom::kTranslation);
}

Pose WithPrediction(const std::vector<Eigen::Vector3f>& points_L, const ModelSurface& surface,
                    const Pose& X_LO_aligned, const Pose& X_LO_predicted, double gate_m,
                    double point_sigma_m, double prior_sigma_m) {
  if (points_L.empty()) return X_LO_predicted;
  const Lever lever = LeverOf(points_L);
  const Normals sums = Linearise(points_L, surface, X_LO_aligned, lever, gate_m);
  // The step from the predicted pose to the aligned one.
  const Pose between = X_LO_aligned * X_LO_predicted.inverse();
  const Eigen::AngleAxisd turn(between.linear());
  Vector6 step;
  step << between * lever.center_L - lever.center_L, lever.length_m * turn.angle() * turn.axis();
  const Matrix6 measured = sums.information / (point_sigma_m * point_sigma_m);
  Vector6 prior;  // things slide rather than turn, where the points leave the choice
  prior << Vector3::Constant(1), Vector3::Constant(1 / (kTurnShare * kTurnShare));
  const Matrix6 all = measured + Matrix6(prior.asDiagonal()) / (prior_sigma_m * prior_sigma_m);
  const Vector6 likely = all.ldlt().solve(measured * step);
  // Moved turns about the centre of the points, which the predicted pose also places.
  return Moved(X_LO_predicted, likely, lever);
}

}  // namespace cwm::perception
