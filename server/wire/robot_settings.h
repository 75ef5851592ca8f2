// Paddings, scales and tools of a robot.
#pragma once

#include "absl/status/statusor.h"
#include "collision/robot/robot_settings.h"
#include "cwm/v1/robot.pb.h"
#include "server/wire/field_path.h"

namespace cwm::server {

// Checks only the form: links and groups that the robot does not have are refused by ReadRobot.
absl::StatusOr<collision::RobotSettings> RobotSettingsFromProto(const v1::LoadRobotHeader& header,
                                                                const FieldPath& path);

// The same for paddings alone.
absl::StatusOr<collision::LinkValues> LinkPaddingsFromProto(
    const google::protobuf::RepeatedPtrField<v1::LinkPadding>& paddings, const FieldPath& path);

v1::RobotTool RobotToolToProto(const collision::RobotTool& tool,
                               const collision::RobotModel& model);

}  // namespace cwm::server
