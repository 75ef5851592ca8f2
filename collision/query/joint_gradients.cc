#include "collision/query/joint_gradients.h"

#include <algorithm>

namespace cwm::collision {
namespace {

constexpr std::size_t kQuaternionAt = 3;  // index among a floating joint's variables

// The angular velocity of the rotation by the normalised quaternion q = x y z w, if q[component]
// grows at speed 1: w = 2 vec(dq conj(q)), where dq is the part of the growth across q, since the
// normalisation takes away the rest.
Vector3 AngularVelocity(const Eigen::Vector4d& q, int component) {
  const double norm = q.norm();
  if (!(norm > 0)) return Vector3::Zero();  // the kinematics then take the identity
  const Eigen::Vector4d unit = q / norm;
  const Eigen::Vector4d growth = (Eigen::Vector4d::Unit(component) - unit[component] * unit) / norm;
  const Quaternion of_growth(growth[3], growth[0], growth[1], growth[2]);
  const Quaternion rotation(unit[3], unit[0], unit[1], unit[2]);
  return 2 * (of_growth * rotation.conjugate()).vec();
}

}  // namespace

JointGradients::JointGradients(const QueryBody& body, const JointRows& rows)
    : body_(body), rows_(rows), width_(rows.group().variables.size()) {
  const std::vector<ModelLink>& links = rows.model().links;
  by_link_.resize(links.size());
  for (std::size_t link = 1; link < links.size(); ++link) {
    by_link_[link] = by_link_[static_cast<std::size_t>(links[link].parent)];
    AddMotions(static_cast<int>(link));
  }
  twists_.resize(motions_.size());
}

void JointGradients::AddMotions(int link) {
  const ModelLink& child = rows_.model().links[static_cast<std::size_t>(link)];
  const std::vector<int>& variables = rows_.group().variables;
  const auto add = [&](int component, LinkMotion motion) {
    const auto at = std::ranges::find(variables, child.variable + component);
    if (at == variables.end()) return;
    motion.link = link;
    motion.column = static_cast<std::size_t>(at - variables.begin());
    by_link_[static_cast<std::size_t>(link)].push_back(motions_.size());
    motions_.push_back(motion);
  };
  switch (child.kind) {
    case JointKind::kFixed:
      break;
    case JointKind::kRevolute:
    case JointKind::kContinuous:
      add(0, {.kind = Kind::kTurn, .multiplier = child.multiplier, .axis_J = child.axis_J});
      break;
    case JointKind::kPrismatic:
      add(0, {.kind = Kind::kSlide, .multiplier = child.multiplier, .axis_J = child.axis_J});
      break;
    case JointKind::kPlanar: {
      const Matrix3 basis = BasisFromZ(child.axis_J);
      for (int k = 0; k < 2; ++k) add(k, {.kind = Kind::kSlide, .axis_J = basis.col(k)});
      add(2, {.kind = Kind::kTurn, .axis_J = child.axis_J});
      break;
    }
    case JointKind::kFloating:
      for (int k = 0; k < 3; ++k) add(k, {.kind = Kind::kSlide, .axis_J = Vector3::Unit(k)});
      for (int k = 0; k < 4; ++k) {
        add(static_cast<int>(kQuaternionAt) + k, {.kind = Kind::kQuaternion, .component = k});
      }
      break;
  }
}

void JointGradients::Place(std::size_t row, std::span<const Pose> X_WL) {
  std::vector<double> state;  // only needed for quaternions
  for (std::size_t k = 0; k < motions_.size(); ++k) {
    const LinkMotion& motion = motions_[k];
    const ModelLink& child = rows_.model().links[static_cast<std::size_t>(motion.link)];
    const Matrix3 R_WJ =
        X_WL[static_cast<std::size_t>(child.parent)].linear() * child.X_PJ.linear();
    Twist& twist = twists_[k];
    // A joint turns about the origin of the link below it, which lies on the axis.
    twist.origin_W = X_WL[static_cast<std::size_t>(motion.link)].translation();
    if (motion.kind == Kind::kQuaternion) {
      if (state.empty()) state = rows_.State(row);
      const auto first = static_cast<std::size_t>(child.variable) + kQuaternionAt;
      const Eigen::Map<const Eigen::Vector4d> q(&state[first]);
      twist.angular_W = R_WJ * AngularVelocity(q, motion.component);
    } else {
      const Vector3 along_W = motion.multiplier * (R_WJ * motion.axis_J);
      (motion.kind == Kind::kTurn ? twist.angular_W : twist.linear_W) = along_W;
    }
  }
}

const std::vector<std::size_t>& JointGradients::MotionsOf(int frame) const {
  const AttachedObject* const attached = body_.AttachedIn(frame);
  return by_link_[static_cast<std::size_t>(attached != nullptr ? attached->link : frame)];
}

void JointGradients::Append(const PairDistance& answer, int frame, int other_frame,
                            std::vector<double>& column) const {
  column.resize(column.size() + width_, 0.0);
  double* const gradient = column.data() + column.size() - width_;
  const std::vector<std::size_t>& of_body = MotionsOf(frame);
  if (other_frame < 0) {
    for (const std::size_t k : of_body) AddTo(gradient, k, -1, answer.point_a, answer.normal);
    return;
  }
  // Motions above both links move the pair as a whole.
  const std::vector<std::size_t>& of_other = MotionsOf(other_frame);
  const auto [mine, theirs] = std::ranges::mismatch(of_body, of_other);
  for (auto k = mine; k != of_body.end(); ++k) {
    AddTo(gradient, *k, -1, answer.point_a, answer.normal);
  }
  for (auto k = theirs; k != of_other.end(); ++k) {
    AddTo(gradient, *k, 1, answer.point_b, answer.normal);
  }
}

void JointGradients::AddTo(double* gradient, std::size_t motion, double sign, const Vector3& p_W,
                           const Vector3& normal_W) const {
  const Twist& twist = twists_[motion];
  const Vector3 velocity_W = twist.angular_W.cross(p_W - twist.origin_W) + twist.linear_W;
  gradient[motions_[motion].column] += sign * normal_W.dot(velocity_W);
}

}  // namespace cwm::collision
