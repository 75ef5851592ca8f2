// Reads the stamped states of a robot that moves.
#pragma once

#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"
#include "collision/world/world_robot.h"
#include "cwm/v1/robot.pb.h"
#include "server/core/live/robot_states.h"
#include "server/wire/field_path.h"

namespace cwm::server {

// The variables that a stream tells, in the order of its rows: those that are named, or all of the
// model. All variables of a joint must be named together, in the order of the model.
absl::StatusOr<collision::JointGroup> ToldVariablesFromProto(const v1::RobotStatesHeader& header,
                                                             const collision::RobotModel& model,
                                                             const FieldPath& path);

// The states of `rows`, one for each stamp, with one value for each told variable. At most
// `max_rows`. Refuses rows as queries about the robot do.
absl::StatusOr<std::vector<StampedRobotState>> StampedStatesFromProto(
    const v1::RobotStateRows& states, const collision::WorldRobotPtr& robot,
    const collision::JointGroup& told, std::int64_t max_rows, const FieldPath& path);

}  // namespace cwm::server
