#include "collision/motion/body_motion.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "absl/container/inlined_vector.h"
#include "collision/geometry/quick_bounds.h"
#include "collision/robot/kinematics.h"

namespace cwm::collision {
namespace {

// The distance of the box's farthest point from the origin.
double ReachOf_m(const Aabb& bounds) {
  return bounds.min().cwiseAbs().cwiseMax(bounds.max().cwiseAbs()).norm();
}

// A bound on the travel of a point at up to `reach_m` from the axis. A half-space reaches to
// infinity, and still does not move if it does not turn.
double SweepOf_m(double turn_rad, double reach_m) { return turn_rad > 0 ? turn_rad * reach_m : 0; }

bool IsRotary(JointKind kind) {
  return kind == JointKind::kRevolute || kind == JointKind::kContinuous;
}

bool IsWholeTurn(double multiplier) { return std::trunc(multiplier) == multiplier; }

constexpr std::size_t kQuaternionAt = 3;  // index among a floating joint's variables

// The rotation of a quaternion of any length; the identity for length 0 (robot/kinematics.h).
Quaternion RotationAt(const double* q) {
  const Quaternion rotation(q[3], q[0], q[1], q[2]);
  return rotation.squaredNorm() > 0 ? rotation.normalized() : Quaternion::Identity();
}

}  // namespace

bool IsCyclic(const RobotModel& model, std::size_t variable) {
  constexpr int kHeading = 2;  // the third variable of a planar joint; no joint mimics it
  const Variable& queried = model.variables[variable];
  const JointKind kind = model.links[static_cast<std::size_t>(queried.link)].kind;
  if (kind == JointKind::kPlanar) return queried.component == kHeading;
  if (kind != JointKind::kContinuous || std::isfinite(queried.lower) ||
      std::isfinite(queried.upper)) {
    return false;
  }
  return std::ranges::all_of(model.links, [&](const ModelLink& link) {
    const bool is_mimic = link.is_mimic && link.variable == static_cast<int>(variable);
    return !is_mimic || (IsRotary(link.kind) && IsWholeTurn(link.multiplier));
  });
}

double StepOf(bool is_cyclic, double from, double to) {
  return is_cyclic ? std::remainder(to - from, 2 * std::numbers::pi) : to - from;
}

RigidMotion::RigidMotion(const QueryBody& body, const Pose& X_WB_from, const Pose& X_WB_to)
    : from_(X_WB_from),
      step_m_(X_WB_to.translation() - X_WB_from.translation()),
      turn_(Matrix3(X_WB_from.linear().transpose() * X_WB_to.linear())) {
  for (const PreparedPart& part : body.geometry->parts) {
    sweep_m_.push_back(SweepOf_m(std::abs(turn_.angle()), ReachOf_m(part.bounds_O)));
  }
}

// A point that turns about an axis moves perpendicularly to the axis, not along it.
double RigidMotion::TravelAlong_m(std::int32_t part, const Vector3& nhat_W) const {
  const Vector3 axis_W = from_.linear() * turn_.axis();
  return nhat_W.dot(step_m_) +
         SweepOf_m(nhat_W.cross(axis_W).norm(), sweep_m_[static_cast<std::size_t>(part)]);
}

Vector3 RigidMotion::Velocity_m(std::span<const Pose> X_WF, std::int32_t,
                                const Vector3& p_W) const {
  const Vector3 turn_W = from_.linear() * (turn_.angle() * turn_.axis());
  return step_m_ + turn_W.cross(p_W - X_WF[0].translation());
}

void RigidMotion::Place(double fraction, std::span<Pose> X_WF) const {
  X_WF[0].linear() =
      from_.linear() * Eigen::AngleAxisd(fraction * turn_.angle(), turn_.axis()).toRotationMatrix();
  X_WF[0].translation() = from_.translation() + fraction * step_m_;
}

JointMotion::JointMotion(const RobotModel& model, const QueryBody& body, const Pose& X_WB,
                         std::span<const double> from, std::span<const double> to)
    : model_(model), body_(body), X_WB_(X_WB), from_(from.begin(), from.end()) {
  for (std::size_t v = 0; v < from.size(); ++v) {
    step_.push_back(StepOf(IsCyclic(model, v), from[v], to[v]));
  }
  std::vector<Pose> X_WL(model.links.size());
  LinkPoses(model, X_WB, from, X_WL);
  for (const ModelLink& link : model.links) {
    JointTravel joint = TravelOf(link, to);
    if (const auto parent = static_cast<std::size_t>(link.parent); parent < joints_.size()) {
      const Matrix3 R_WJ = X_WL[parent].linear() * link.X_PJ.linear();
      joint.slide_W = R_WJ * joint.slide_W;
      joint.axis_W = R_WJ * joint.axis_W;
      joint.is_steady = joints_[parent].is_steady && joints_[parent].turn_rad == 0;
    }
    joints_.push_back(joint);
  }
}

JointMotion::JointTravel JointMotion::TravelOf(const ModelLink& link, std::span<const double> to) {
  const auto first = static_cast<std::size_t>(link.variable);
  const double factor = link.is_mimic ? link.multiplier : 1;
  // A straight motion from the joint's origin: the link is farthest from it at one of the ends.
  const auto straight = [](const Vector3& from_J, const Vector3& slide_J) {
    return JointTravel{.slide_W = slide_J,
                       .arm_m = std::max(from_J.norm(), (from_J + slide_J).norm())};
  };
  switch (link.kind) {
    case JointKind::kFixed:
      return {};
    case JointKind::kRevolute:
    case JointKind::kContinuous:
      return {.turn_rad = std::abs(factor * step_[first]), .axis_W = link.axis_J};
    case JointKind::kPrismatic: {
      const double offset = link.is_mimic ? link.offset : 0;
      return straight((factor * from_[first] + offset) * link.axis_J,
                      factor * step_[first] * link.axis_J);
    }
    case JointKind::kPlanar: {
      const Eigen::Matrix<double, 3, 2> plane = BasisFromZ(link.axis_J).leftCols<2>();
      JointTravel travel = straight(plane * Vector2(&from_[first]), plane * Vector2(&step_[first]));
      travel.turn_rad = std::abs(step_[first + 2]);
      travel.axis_W = link.axis_J;
      return travel;
    }
    case JointKind::kFloating: {
      JointTravel travel = straight(Vector3(&from_[first]), Vector3(&step_[first]));
      if (const Turn* const turn = AddTurn(first + kQuaternionAt, to)) {
        travel.turn_rad = turn->whole.angle();  // >= 0, because it comes from a quaternion
        travel.axis_W = turn->from * turn->whole.axis();
      }
      return travel;
    }
  }
  return {};
}

const JointMotion::Turn* JointMotion::AddTurn(std::size_t first, std::span<const double> to) {
  const auto same = [&](std::size_t v) { return from_[v] == to[v]; };
  if (same(first) && same(first + 1) && same(first + 2) && same(first + 3)) return nullptr;
  const Quaternion from = RotationAt(&from_[first]);
  const Eigen::AngleAxisd whole(from.conjugate() * RotationAt(&to[first]));
  return &turns_.emplace_back(Turn{first, from, whole});
}

void JointMotion::Place(double fraction, std::span<Pose> X_WL) const {
  absl::InlinedVector<double, 32> variables(from_.begin(), from_.end());
  for (std::size_t v = 0; v < variables.size(); ++v) variables[v] += fraction * step_[v];
  for (const Turn& turn : turns_) {
    const Eigen::AngleAxisd part(fraction * turn.whole.angle(), turn.whole.axis());
    const Eigen::Vector4d q = (turn.from * Quaternion(part)).coeffs();  // x y z w
    std::ranges::copy(q, &variables[turn.first]);
  }
  LinkPoses(model_, X_WB_, variables, X_WL);
}

int JointMotion::LinkOf(std::int32_t part) const {
  const int frame = body_.FrameOf(part);
  const AttachedObject* const attached = body_.AttachedIn(frame);
  return attached != nullptr ? attached->link : frame;
}

double JointMotion::Reach_m(std::int32_t part) const {
  const Aabb& bounds = body_.geometry->parts[static_cast<std::size_t>(part)].bounds_O;
  const AttachedObject* const attached = body_.AttachedIn(body_.FrameOf(part));
  return attached == nullptr ? ReachOf_m(bounds) : ReachOf_m(BoundsOfBox(bounds, attached->X_FO));
}

// Walks from the part's link towards the root. Each joint turns everything below it about its own
// origin, or, if it also slides, about its link's origin. `of` is called with the joint and the
// part's reach from that origin.
template <class Of>
double JointMotion::SumBelow_m(std::int32_t part, int above, Of&& of) const {
  double reach_m = Reach_m(part);
  double travel_m = 0;
  for (int link = LinkOf(part); link != above;) {
    const auto k = static_cast<std::size_t>(link);
    const ModelLink& model_link = model_.links[k];
    travel_m += of(joints_[k], reach_m);
    reach_m += joints_[k].arm_m;                      // measured from the joint's origin
    reach_m += model_link.X_PJ.translation().norm();  // measured from the parent's origin
    if (link == model_link.parent) break;             // the root
    link = model_link.parent;
  }
  return travel_m;
}

double JointMotion::TravelBelow_m(std::int32_t part, int above) const {
  return SumBelow_m(part, above, [](const JointTravel& joint, double reach_m) {
    return SweepOf_m(joint.turn_rad, reach_m) + joint.slide_W.norm();
  });
}

// Same as for a rigid body, except that the direction of a joint's motion changes if a joint above
// it turns; for such a joint the direction is ignored.
double JointMotion::TravelAlong_m(std::int32_t part, const Vector3& nhat_W) const {
  return SumBelow_m(part, -1, [&](const JointTravel& joint, double reach_m) {
    if (!joint.is_steady) return SweepOf_m(joint.turn_rad, reach_m) + joint.slide_W.norm();
    const double turn_rad = joint.turn_rad * nhat_W.cross(joint.axis_W).norm();
    return nhat_W.dot(joint.slide_W) + SweepOf_m(turn_rad, reach_m);
  });
}

int JointMotion::CommonAncestor(int link, int other) const {
  while (link != other) {  // parents have lower indices
    int& later = link > other ? link : other;
    later = model_.links[static_cast<std::size_t>(later)].parent;
  }
  return link;
}

double JointMotion::Travel_m(std::int32_t part) const { return TravelBelow_m(part, -1); }

double JointMotion::RelativeTravel_m(const PartPair& pair) const {
  const int ancestor = CommonAncestor(LinkOf(pair.first), LinkOf(pair.second));
  return TravelBelow_m(pair.first, ancestor) + TravelBelow_m(pair.second, ancestor);
}

Vector3 JointMotion::Velocity_m(std::span<const Pose> X_WF, std::int32_t part,
                                const Vector3& p_W) const {
  Vector3 velocity_m = Vector3::Zero();
  for (int link = LinkOf(part); link > 0;) {
    const auto k = static_cast<std::size_t>(link);
    const ModelLink& model_link = model_.links[k];
    const auto first = static_cast<std::size_t>(model_link.variable);
    const double factor = model_link.is_mimic ? model_link.multiplier : 1;
    // A joint turns about its axis, or slides along it, as the link does that it moves.
    const Vector3 axis_W = X_WF[k].linear() * model_link.axis_J;
    if (IsRotary(model_link.kind)) {
      velocity_m += factor * step_[first] * axis_W.cross(p_W - X_WF[k].translation());
    } else if (model_link.kind == JointKind::kPrismatic) {
      velocity_m += factor * step_[first] * axis_W;
    }
    link = model_link.parent;
  }
  return velocity_m;
}

double JointMotion::BendBelow_m(std::int32_t part, int above) const {
  double reach_m = Reach_m(part);
  double speed_m = 0, bend_m = 0;
  for (int link = LinkOf(part); link != above;) {
    const auto k = static_cast<std::size_t>(link);
    const ModelLink& model_link = model_.links[k];
    const JointTravel& joint = joints_[k];
    const bool is_known =
        model_link.kind != JointKind::kPlanar && model_link.kind != JointKind::kFloating;
    if (!is_known && (joint.turn_rad > 0 || joint.slide_W != Vector3::Zero())) {
      return std::numeric_limits<double>::infinity();
    }
    if (joint.turn_rad > 0) {
      bend_m += joint.turn_rad * (joint.turn_rad * reach_m + 2 * speed_m);
      speed_m += joint.turn_rad * reach_m;
    }
    speed_m += joint.slide_W.norm();
    reach_m += joint.arm_m + model_link.X_PJ.translation().norm();
    if (link == model_link.parent) break;  // the root
    link = model_link.parent;
  }
  return bend_m;
}

double JointMotion::RelativeBend_m(const PartPair& pair) const {
  const int ancestor = CommonAncestor(LinkOf(pair.first), LinkOf(pair.second));
  return BendBelow_m(pair.first, ancestor) + BendBelow_m(pair.second, ancestor);
}

}  // namespace cwm::collision
