#include "collision/world/robot_transaction.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "collision/robot/state_range.h"
#include "collision/world/apply_fault.h"
#include "collision/world/model_equality.h"
#include "collision/world/robot_state.h"

namespace cwm::collision {
namespace {

bool SameBaseAndState(const WorldRobot& a, const WorldRobot& b) {
  return SamePose(a.X_WB, b.X_WB) && a.state == b.state;
}

}  // namespace

absl::Status RobotTransaction::Put(const PutRobot& put) {
  if (!IsValidName(put.name)) return InvalidNameError(put.name);
  if (!IsPlaceable(put.X_WB)) return InvalidPoseError("x_world_base");
  if (put.robot == nullptr) return InvalidFieldError("robot", "must be given");
  if (!IsState(*put.robot->model, put.state)) {
    return InvalidFieldError("state", "must hold one finite value for each variable of the robot");
  }
  if (const auto fault = StateFault(*put.robot->model, put.X_WB, put.state)) {
    return InvalidFieldError("state", *fault);
  }
  const WorldRobot* current = Current(put.name);
  WorldRobot robot;
  if (current != nullptr && SameRobot(*current->robot, *put.robot)) {
    robot = *current;
  } else {
    robot.name = put.name;
    robot.robot = put.robot;
    robot.create_revision = revision_;
    robot.state_revision = revision_;
  }
  robot.X_WB = put.X_WB;
  robot.state = put.state;
  Touch(std::move(robot));
  return absl::OkStatus();
}

absl::Status RobotTransaction::Remove(const RemoveRobot& remove) {
  if (!Has(remove.name)) return RobotNotFoundError(remove.name);
  touched_[remove.name] = std::nullopt;
  return absl::OkStatus();
}

absl::Status RobotTransaction::Set(const SetRobotState& set) {
  const WorldRobot* current = Current(set.name);
  if (current == nullptr) return RobotNotFoundError(set.name);
  if (set.X_WB.has_value() && !IsPlaceable(*set.X_WB)) return InvalidPoseError("x_world_base");
  absl::StatusOr<std::vector<double>> state =
      StateWith(current->model(), current->state, set.joints);
  if (!state.ok()) {
    const std::optional<FieldRule> fault = FieldRuleOf(state.status());
    return fault ? InvalidFieldError(absl::StrCat("joints.", fault->field), fault->rule)
                 : state.status();
  }
  WorldRobot robot = *current;
  robot.X_WB = set.X_WB.value_or(current->X_WB);
  robot.state = *std::move(state);
  if (const auto fault = StateFault(robot.model(), robot.X_WB, robot.state)) {
    return InvalidFieldError(set.X_WB.has_value() ? "x_world_base" : "joints", *fault);
  }
  Touch(std::move(robot));
  return absl::OkStatus();
}

std::vector<RobotDelta> RobotTransaction::Finish() {
  std::vector<RobotDelta> deltas;
  for (auto& [name, robot] : touched_) {
    WorldRobotPtr before = base_.FindRobot(name);
    if (before == nullptr && !robot.has_value()) continue;
    const bool is_same_robot = before != nullptr && robot.has_value() && before->IsSameAs(*robot);
    if (is_same_robot && SameBaseAndState(*before, *robot)) continue;
    if (is_same_robot) robot->state_revision = revision_;
    deltas.push_back({.before = std::move(before),
                      .after = robot.has_value() ? Place(*std::move(robot)) : nullptr});
  }
  return deltas;
}

const WorldRobot* RobotTransaction::Current(const std::string& name) const {
  const auto at = touched_.find(name);
  if (at != touched_.end()) return at->second.has_value() ? &*at->second : nullptr;
  return base_.FindRobot(name).get();  // kept alive by the base
}

void RobotTransaction::Touch(WorldRobot robot) {
  PlaceLinks(robot);
  std::string name = robot.name;
  touched_[std::move(name)] = std::move(robot);
}

}  // namespace cwm::collision
