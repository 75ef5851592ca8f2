// Robots as replies and events show them, and what sets their state.
#pragma once

#include "absl/status/statusor.h"
#include "collision/world/world_robot.h"
#include "collision/world/world_snapshot.h"
#include "cwm/v1/robot.pb.h"
#include "cwm/v1/robot_model.pb.h"
#include "server/core/geometry_store.h"
#include "server/wire/field_path.h"

namespace cwm::server {

v1::JointKind ToProto(collision::JointKind kind);

// Unlimited variables have no limits; what mimics another joint is not among the variables.
v1::Robot ToProto(const collision::WorldRobot& robot);
// The poses of all links as the robot stands, and with `shapes` what of them collides: meshes
// become readable by their hash.
enum class LinkShapes { kNone, kAll };
void SetLinks(const collision::WorldRobot& robot, LinkShapes shapes, GeometryStore& store,
              v1::GetRobotLinksResponse* response);

v1::RobotStateEvent ToStateEvent(const collision::WorldRobot& robot);

// The form alone: whether the robot has such groups and variables is told when it is applied
// (collision::StateWith). A group needs its state and the other way round.
absl::StatusOr<collision::JointValues> FromProto(const v1::RobotJointState& joints,
                                                 const FieldPath& path);
absl::StatusOr<collision::SetRobotState> FromProto(const v1::SetRobotState& set,
                                                   const FieldPath& path);

}  // namespace cwm::server
