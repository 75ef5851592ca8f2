#include "collision/spheres/lane_frames.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "collision/robot/kinematics.h"
#include "collision/spheres/sphere_lanes.h"

namespace cwm::collision {
namespace {

// chosen: larger angles lose digits in the reduction to [-pi, pi].
constexpr double kMaxTurn_rad = 1e4;

}  // namespace

LaneFrames::LaneFrames(const RobotModel& model, const JointGroup& group,
                       std::span<const double> base)
    : model_(&model), column_of_(model.variables.size(), -1), X_BL_(model.links.size()) {
  LinkPoses(model, Pose::Identity(), base, X_BL_);
  for (std::size_t k = 0; k < group.variables.size(); ++k) {
    column_of_[static_cast<std::size_t>(group.variables[k])] = static_cast<int>(k);
  }
}

std::optional<LaneFrames> LaneFrames::Of(const RobotModel& model, const JointGroup& group,
                                         std::span<const double> base,
                                         std::span<const FixedFrame> fixed_frames) {
  LaneFrames frames(model, group, base);
  if (!frames.AddLinks()) return std::nullopt;
  frames.AddFixedFrames(fixed_frames);
  return frames;
}

bool LaneFrames::AddLinks() {
  joints_.emplace_back();
  // Scenes rotate the root (LaneScene::rotation) by a matrix of nine rounded numbers.
  frames_.emplace_back().rotation_error = 2 * kFloatRounding;
  links_.push_back({.frame = 0, .X_FL = Pose::Identity()});
  for (std::size_t i = 1; i < model_->links.size(); ++i) {
    if (!AddLink(i)) return false;
  }
  return true;
}

void LaneFrames::AddFixedFrames(std::span<const FixedFrame> fixed_frames) {
  for (const FixedFrame& each : fixed_frames) {
    const Fixed link = links_[static_cast<std::size_t>(each.link)];
    links_.push_back({.frame = link.frame, .X_FL = link.X_FL * each.X_LF});
  }
}

bool LaneFrames::AddLink(std::size_t index) {
  const ModelLink& link = model_->links[index];
  const Fixed& parent = links_[static_cast<std::size_t>(link.parent)];
  const bool moves =
      link.kind != JointKind::kFixed && column_of_[static_cast<std::size_t>(link.variable)] >= 0;
  if (!moves) {
    const Pose X_PL = X_BL_[static_cast<std::size_t>(link.parent)].inverse() * X_BL_[index];
    links_.push_back({.frame = parent.frame, .X_FL = parent.X_FL * X_PL});
    return true;
  }
  if (link.kind == JointKind::kPlanar || link.kind == JointKind::kFloating) return false;
  AddJoint(link, parent);
  return true;
}

void LaneFrames::AddJoint(const ModelLink& link, const Fixed& parent) {
  const bool turns = link.kind != JointKind::kPrismatic;
  const Matrix3 to_axis = BasisFromZ(link.axis_J);
  Pose X_PF = parent.X_FL * link.X_PJ;
  X_PF.linear() = X_PF.linear() * to_axis;
  LaneJoint joint{.parent = frames_[parent.frame].index, .turns = turns};
  for (int i = 0; i < 9; ++i) joint.rotation[i] = static_cast<float>(X_PF.linear()(i / 3, i % 3));
  for (int i = 0; i < 3; ++i) joint.shift_m[i] = static_cast<float>(X_PF.translation()[i]);
  for (int i = 0; i < 9; ++i) joint.exact_rotation[i] = X_PF.linear()(i / 3, i % 3);
  for (int i = 0; i < 3; ++i) joint.exact_shift_m[i] = X_PF.translation()[i];
  const Variable& variable = model_->variables[static_cast<std::size_t>(link.variable)];
  const double farthest_variable =
      std::max(std::abs(variable.lower), std::abs(variable.upper)) * std::abs(link.multiplier) +
      std::abs(link.offset);
  const double farthest = turns ? kMaxTurn_rad : std::min(farthest_variable, kMaxSlide_m);
  const double max_value = turns ? std::numbers::pi : farthest;
  const double at_lower = link.multiplier * variable.lower + link.offset;
  const double at_upper = link.multiplier * variable.upper + link.offset;
  inputs_.push_back(
      {.column = static_cast<std::size_t>(column_of_[static_cast<std::size_t>(link.variable)]),
       .lower_limit = std::max(variable.lower, -std::numeric_limits<double>::max()),
       .upper_limit = std::min(variable.upper, std::numeric_limits<double>::max()),
       .multiplier = link.multiplier,
       .offset = link.offset,
       .turns = turns,
       .stays_near = std::max(std::abs(at_lower), std::abs(at_upper)) <= max_value,
       .lower = std::clamp(std::min(at_lower, at_upper), -max_value, max_value),
       .upper = std::clamp(std::max(at_lower, at_upper), -max_value, max_value),
       .lever_m = 0,
       .farthest = farthest});
  frames_.push_back(Below(frames_[parent.frame], X_PF.translation(), turns ? 0.0 : farthest));
  frames_.back().parent = parent.frame;
  if (turns) {
    const auto [lower, upper] = std::minmax(at_lower, at_upper);
    const bool has_limits = upper - lower < 2 * std::numbers::pi;  // false if not a number
    frames_.back().turning = RevoluteJoint{.X_PF = X_PF,
                                           .lower_rad = has_limits ? lower : -std::numbers::pi,
                                           .upper_rad = has_limits ? upper : std::numbers::pi};
  }
  joints_.push_back(joint);
  Pose X_FL = Pose::Identity();
  X_FL.linear() = to_axis.transpose();
  links_.push_back({.frame = frames_.size() - 1, .X_FL = X_FL});
}

// The frame below a joint with bounds on its rounding errors, to first order. Each bound is
// slightly larger than what the products and sums of Hung and Place (sphere_lanes.cc) cause. u is
// kFloatRounding, norms are Frobenius norms.
LaneFrames::Frame LaneFrames::Below(const Frame& parent, const Vector3& shift,
                                    double travel_m) const {
  constexpr double u = kFloatRounding;
  Frame frame;
  frame.index = static_cast<std::int32_t>(frames_.size());
  const double shift_m = shift.norm();
  if (parent.index == 0) {
    frame.reach = {shift, travel_m};
  } else {
    frame.reach = {parent.reach.centre, parent.reach.radius_m + shift_m + travel_m};
  }
  const double out_m = frame.reach.centre.norm() + frame.reach.radius_m;
  // The fixed rotation contributes its own rounding and a 3 x 3 product. The joint's rotation
  // contributes two columns, each with two products by numbers with an error of kSineError.
  const double product = parent.rotation_error + 12 * u;
  frame.rotation_error = product + 3 * kSineError + 6 * u;
  frame.origin_error_m =
      parent.origin_error_m + product * (shift_m + travel_m) + 8 * u * (shift_m + travel_m + out_m);
  return frame;
}

}  // namespace cwm::collision
