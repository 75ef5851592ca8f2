// A world as a planning scene, the input of the writers of MoveIt's formats.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "collision/world/world_snapshot.h"
#include "server/export/cancellation_check.h"
#include "server/export/planner_shape.h"

namespace cwm::server {

// The link that holds an object.
struct PlannedAttachment {
  std::string robot;
  std::string link;
  Pose X_LO = Pose::Identity();
  std::vector<std::string> touch_links;
  std::string supported_by = {};  // its supporter, which it may touch but which a scene cannot
                                  // express; empty: none
};

struct PlannedObject {
  std::string name;
  Pose X_WO = Pose::Identity();
  std::vector<PlannerShape> shapes;                            // at least one
  std::optional<PlannedAttachment> attachment = std::nullopt;  // empty: not attached
};

struct PlannedJoint {
  std::string name;
  double position = 0;  // rad or m
};
struct PlannedMultiDofJoint {
  std::string name;
  Pose transform = Pose::Identity();
};

struct PlannedRobotState {
  std::vector<PlannedJoint> joints;
  // The base comes first, as the virtual joint that connects the robot to the world in MoveIt.
  std::vector<PlannedMultiDofJoint> multi_dof_joints;
};

// The allowed collisions: names of links and objects, each once, and a square matrix.
struct AllowedCollisionMatrix {
  std::vector<std::string> names;
  std::vector<std::vector<bool>> allowed;
  std::vector<std::string> by_default;  // names that may touch whatever is not in the matrix
};

struct PlanningScene {
  std::string name;        // the world's name
  std::string robot_name;  // the name in the robot's description; empty: no robot
  std::vector<PlannedObject> objects;
  PlannedRobotState robot_state;
  AllowedCollisionMatrix allowed;
  std::vector<std::string> warnings;  // what a planning scene expresses differently, or not at all
};

// chosen: the most names in a matrix, whose text then has about 25 MB. Robots have about a hundred
// links.
inline constexpr std::size_t kMaxMatrixNames = 2'048;

// The objects of a snapshot, by name: every part that collision checking sees. ResourceExhausted
// GEOMETRY_TOO_LARGE if their meshes have more than `max_triangles` together.
absl::StatusOr<PlanningScene> MakePlanningScene(
    const collision::WorldSnapshot& snapshot, std::int64_t max_triangles,
    const CancellationCheck& check_cancelled = absl::OkStatus);

// Adds the robot's state and base (`robot` may be null) and the allowed collisions. Links that the
// robot does not check against each other are allowed to collide. An object attached to another
// robot becomes a free object at its present pose. Fails with the errors of
// MakeAllowedCollisionMatrix.
absl::Status AddRobotAndRules(const collision::WorldSnapshot& snapshot,
                              const collision::WorldRobot* robot, PlanningScene& scene,
                              const CancellationCheck& check_cancelled = absl::OkStatus);

// Removes attached objects, with a warning: in a format that has only objects they would be
// obstacles for the robot that holds them.
void RemoveAttached(PlanningScene& scene);

// Only the matrix; adds warnings about rules that it cannot express. ResourceExhausted
// EXPORT_TOO_LARGE if it would have more than kMaxMatrixNames names.
absl::StatusOr<AllowedCollisionMatrix> MakeAllowedCollisionMatrix(
    const collision::WorldSnapshot& snapshot, const collision::WorldRobot* robot,
    std::vector<std::string>& warnings, const CancellationCheck& check_cancelled = absl::OkStatus);

}  // namespace cwm::server
