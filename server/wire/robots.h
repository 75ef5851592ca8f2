// Converts robots for replies and events, and reads changes of their state.
#pragma once

#include "absl/status/statusor.h"
#include "collision/world/world_robot.h"
#include "collision/world/world_snapshot.h"
#include "cwm/v1/robot.pb.h"
#include "cwm/v1/robot_model.pb.h"
#include "server/core/geometry_store.h"
#include "server/wire/field_path.h"

namespace cwm::server {

v1::JointKind JointKindToProto(collision::JointKind kind);

// Unlimited variables have no limits; joints that mimic another are not among the variables.
v1::Robot RobotToProto(const collision::WorldRobot& robot);
// The poses of all links in the robot's present state, and with `shapes` their collision geometry;
// its meshes become readable by their hash.
enum class LinkShapes { kNone, kAll };
void SetLinks(const collision::WorldRobot& robot, LinkShapes shapes, GeometryStore& store,
              v1::GetRobotLinksResponse* response);

v1::RobotStateEvent ToStateEvent(const collision::WorldRobot& robot);

// Checks only the form: missing groups and variables are reported when the state is applied
// (collision::StateWith). A group needs its state and vice versa.
absl::StatusOr<collision::JointValues> JointValuesFromProto(const v1::RobotJointState& joints,
                                                            const FieldPath& path);
absl::StatusOr<collision::SetRobotState> SetRobotStateFromProto(const v1::SetRobotState& set,
                                                                const FieldPath& path);

}  // namespace cwm::server
