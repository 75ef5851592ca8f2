#include "collision/motion/body_motion.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "absl/container/inlined_vector.h"
#include "collision/geometry/quick_bounds.h"
#include "collision/robot/kinematics.h"

namespace cwm::collision {
namespace {

// How far the farthest point of a box is from the origin.
double ReachOf_m(const Aabb& bounds) {
  return bounds.min().cwiseAbs().cwiseMax(bounds.max().cwiseAbs()).norm();
}

// How far a turn takes what reaches so far from its axis. A half-space reaches to infinity, and yet
// is not moved where it is not turned.
double SweepOf_m(double turn_rad, double reach_m) { return turn_rad > 0 ? turn_rad * reach_m : 0; }

// The short way around.
double TurnBetween(double from_rad, double to_rad) {
  return std::remainder(to_rad - from_rad, 2 * std::numbers::pi);
}

bool IsRotary(JointKind kind) {
  return kind == JointKind::kRevolute || kind == JointKind::kContinuous;
}

// Whether a whole turn of the variable leaves the robot as it was: of a continuous joint that
// nothing follows but what turns with it a whole number of times. Else the short way would end
// elsewhere than the row says.
bool ComesAround(const RobotModel& model, std::size_t variable) {
  const auto joint = static_cast<std::size_t>(model.variables[variable].link);
  if (model.links[joint].kind != JointKind::kContinuous) return false;
  return std::ranges::all_of(model.links, [&](const ModelLink& link) {
    const bool follows = link.follows && link.variable == static_cast<int>(variable);
    return !follows || (IsRotary(link.kind) && std::trunc(link.multiplier) == link.multiplier);
  });
}

}  // namespace

RigidMotion::RigidMotion(const QueryBody& body, const Pose& X_WB_from, const Pose& X_WB_to)
    : from_(X_WB_from),
      step_m_(X_WB_to.translation() - X_WB_from.translation()),
      turn_(Matrix3(X_WB_from.linear().transpose() * X_WB_to.linear())) {
  for (const PreparedPart& part : body.geometry->parts) {
    sweep_m_.push_back(SweepOf_m(std::abs(turn_.angle()), ReachOf_m(part.bounds_O)));
  }
}

// A point that turns about an axis moves perpendicularly to it: along the axis not at all.
double RigidMotion::TravelAlong_m(std::int32_t part, const Vector3& nhat_W) const {
  const Vector3 axis_W = from_.linear() * turn_.axis();
  return nhat_W.dot(step_m_) +
         SweepOf_m(nhat_W.cross(axis_W).norm(), sweep_m_[static_cast<std::size_t>(part)]);
}

void RigidMotion::Place(double fraction, std::span<Pose> X_WF) const {
  X_WF[0].linear() =
      from_.linear() * Eigen::AngleAxisd(fraction * turn_.angle(), turn_.axis()).toRotationMatrix();
  X_WF[0].translation() = from_.translation() + fraction * step_m_;
}

std::optional<int> JointMotion::FirstNotFollowed(const RobotModel& model,
                                                 std::span<const double> from,
                                                 std::span<const double> to) {
  for (std::size_t k = 0; k < model.links.size(); ++k) {
    const ModelLink& link = model.links[k];
    if (link.kind != JointKind::kPlanar && link.kind != JointKind::kFloating) continue;
    const auto first = static_cast<std::size_t>(link.variable);
    const auto count = static_cast<std::size_t>(VariableCount(link.kind));
    const bool stands = std::ranges::equal(from.subspan(first, count), to.subspan(first, count));
    if (!stands) return static_cast<int>(k);
  }
  return std::nullopt;
}

JointMotion::JointMotion(const RobotModel& model, const QueryBody& body, const Pose& X_WB,
                         std::span<const double> from, std::span<const double> to)
    : model_(model), body_(body), X_WB_(X_WB), from_(from.begin(), from.end()) {
  for (std::size_t v = 0; v < from.size(); ++v) {
    step_.push_back(ComesAround(model, v) ? TurnBetween(from[v], to[v]) : to[v] - from[v]);
  }
  for (const ModelLink& link : model.links) {
    const bool moves = IsRotary(link.kind) || link.kind == JointKind::kPrismatic;
    const auto variable = static_cast<std::size_t>(link.variable);
    const double factor = link.follows ? link.multiplier : 1;
    const double step = moves ? std::abs(factor * step_[variable]) : 0;
    turn_rad_.push_back(IsRotary(link.kind) ? step : 0);
    slide_m_.push_back(link.kind == JointKind::kPrismatic ? step : 0);
    double arm_m = 0;  // of sliding joints, at either end of the edge
    if (link.kind == JointKind::kPrismatic) {
      const double offset = link.follows ? link.offset : 0;
      arm_m = std::max(std::abs(factor * from_[variable] + offset),
                       std::abs(factor * (from_[variable] + step_[variable]) + offset));
    } else if (link.kind == JointKind::kPlanar || link.kind == JointKind::kFloating) {
      const std::size_t axes = link.kind == JointKind::kPlanar ? 2 : 3;
      for (std::size_t k = 0; k < axes; ++k) arm_m = std::hypot(arm_m, from_[variable + k]);
    }
    arm_m_.push_back(arm_m);
  }
}

void JointMotion::Place(double fraction, std::span<Pose> X_WL) const {
  absl::InlinedVector<double, 32> variables(from_.begin(), from_.end());
  for (std::size_t v = 0; v < variables.size(); ++v) variables[v] += fraction * step_[v];
  LinkPoses(model_, X_WB_, variables, X_WL);
}

int JointMotion::LinkOf(std::int32_t part) const {
  const int frame = body_.FrameOf(part);
  const CarriedObject* const carried = body_.CarriedIn(frame);
  return carried != nullptr ? carried->link : frame;
}

double JointMotion::Reach_m(std::int32_t part) const {
  const Aabb& bounds = body_.geometry->parts[static_cast<std::size_t>(part)].bounds_O;
  const CarriedObject* const carried = body_.CarriedIn(body_.FrameOf(part));
  return carried == nullptr ? ReachOf_m(bounds) : ReachOf_m(BoundsOfBox(bounds, carried->X_FO));
}

// From the part outward in: each joint turns all that hangs on it about its own origin.
double JointMotion::TravelBelow_m(std::int32_t part, int above) const {
  double reach_m = Reach_m(part);
  double travel_m = 0;
  for (int link = LinkOf(part); link != above;) {
    const auto k = static_cast<std::size_t>(link);
    const ModelLink& model_link = model_.links[k];
    reach_m += arm_m_[k];  // about the joint's origin
    travel_m += turn_rad_[k] * reach_m + slide_m_[k];
    reach_m += model_link.X_PJ.translation().norm();  // about the parent's origin
    if (link == model_link.parent) break;             // the root
    link = model_link.parent;
  }
  return travel_m;
}

int JointMotion::CommonAncestor(int link, int other) const {
  while (link != other) {  // parents have lesser indices
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

}  // namespace cwm::collision
