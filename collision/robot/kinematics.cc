#include "collision/robot/kinematics.h"

#include <cassert>
#include <cmath>

namespace cwm::collision {
namespace {

// chosen: the precision with which states are commonly written; a larger deviation is a mistake.
constexpr double kQuaternionTolerance = 0.01;

constexpr int kQuaternionAt = 3;  // index among a floating joint's variables

double QuaternionNorm(const double* q) {
  return std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
}

Pose FloatingMotion(const double* v) {
  const double* q = v + kQuaternionAt;
  const double norm = QuaternionNorm(q);
  if (!(norm > 0)) return MakeTranslation(v[0], v[1], v[2]);
  const Quaternion rotation(q[3] / norm, q[0] / norm, q[1] / norm, q[2] / norm);
  return MakePose({v[0], v[1], v[2]}, rotation);
}

Pose PlanarMotion(const Vector3& axis_J, const double* v) {
  const Matrix3 basis = BasisFromZ(axis_J);
  Pose motion = Pose::Identity();
  motion.linear() = Eigen::AngleAxisd(v[2], axis_J).toRotationMatrix();
  motion.translation() = v[0] * basis.col(0) + v[1] * basis.col(1);
  return motion;
}

// A frame after a rotation about an axis fixed in it. For the z axis, which most joints have, only
// the other two columns change.
Matrix3 Turned(const Matrix3& R_WJ, const Vector3& axis_J, double angle_rad) {
  if (axis_J != Vector3::UnitZ()) {
    return R_WJ * Eigen::AngleAxisd(angle_rad, axis_J).toRotationMatrix();
  }
  const double s = std::sin(angle_rad), c = std::cos(angle_rad);
  Matrix3 R_WC;
  R_WC.col(0) = c * R_WJ.col(0) + s * R_WJ.col(1);
  R_WC.col(1) = c * R_WJ.col(1) - s * R_WJ.col(0);
  R_WC.col(2) = R_WJ.col(2);
  return R_WC;
}

// X_WP * X_PC for the link below P.
Pose Moved(const Pose& X_WP, const ModelLink& link, std::span<const double> variables) {
  const Pose X_WJ = X_WP * link.X_PJ;
  if (link.kind == JointKind::kFixed) return X_WJ;
  const double* v = &variables[link.variable];
  if (link.kind == JointKind::kFloating) return X_WJ * FloatingMotion(v);
  if (link.kind == JointKind::kPlanar) return X_WJ * PlanarMotion(link.axis_J, v);
  const double value = link.multiplier * *v + link.offset;
  Pose X_WC = X_WJ;
  if (link.kind == JointKind::kPrismatic) {
    X_WC.translation() += X_WJ.linear() * (value * link.axis_J);
  } else {
    X_WC.linear() = Turned(X_WJ.linear(), link.axis_J, value);
  }
  return X_WC;
}

}  // namespace

void LinkPoses(const RobotModel& model, const Pose& X_WB, std::span<const double> variables,
               std::span<Pose> X_WL) {
  assert(variables.size() == model.variables.size() && X_WL.size() == model.links.size());
  X_WL[0] = X_WB;
  for (std::size_t i = 1; i < model.links.size(); ++i) {
    X_WL[i] = Moved(X_WL[model.links[i].parent], model.links[i], variables);
  }
}

void MovedLinkPoses(const RobotModel& model, const JointGroup& group,
                    std::span<const double> variables, std::span<Pose> X_WL) {
  assert(variables.size() == model.variables.size() && X_WL.size() == model.links.size());
  for (const int i : group.moved_links) {
    X_WL[i] = Moved(X_WL[model.links[i].parent], model.links[i], variables);
  }
}

std::optional<int> OutOfLimits(const RobotModel& model, std::span<const double> variables) {
  assert(variables.size() == model.variables.size());
  for (std::size_t i = 0; i < variables.size(); ++i) {
    const Variable& variable = model.variables[i];
    if (!(variables[i] >= variable.lower && variables[i] <= variable.upper) ||
        !std::isfinite(variables[i])) {
      return static_cast<int>(i);
    }
    if (model.links[variable.link].kind != JointKind::kFloating ||
        variable.component != kQuaternionAt) {
      continue;
    }
    if (!(std::abs(QuaternionNorm(&variables[i]) - 1) <= kQuaternionTolerance)) {
      return static_cast<int>(i);
    }
  }
  return std::nullopt;
}

std::vector<double> DefaultVariables(const RobotModel& model) {
  constexpr int kQw = 6;
  std::vector<double> values;
  for (const Variable& variable : model.variables) {
    const bool is_zero_inside = variable.lower <= 0 && variable.upper >= 0;
    const bool is_qw =
        model.links[variable.link].kind == JointKind::kFloating && variable.component == kQw;
    values.push_back(is_qw            ? 1
                     : is_zero_inside ? 0
                                      : variable.lower + (variable.upper - variable.lower) / 2);
  }
  return values;
}

}  // namespace cwm::collision
