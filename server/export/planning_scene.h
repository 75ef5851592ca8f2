// A world as a planning scene: values that the writers of MoveIt's formats write.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "collision/world/world_snapshot.h"
#include "server/export/go_on.h"
#include "server/export/planner_shape.h"

namespace cwm::server {

// What an object is held by.
struct PlannedAttachment {
  std::string robot;
  std::string link;
  Pose X_LO = Pose::Identity();
  std::vector<std::string> touch_links;
  std::string supported_by = {};  // which it may touch, and no scene can say; empty: nothing
};

struct PlannedObject {
  std::string name;
  Pose X_WO = Pose::Identity();
  std::vector<PlannerShape> shapes;                            // at least one
  std::optional<PlannedAttachment> attachment = std::nullopt;  // absent: stands free
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
  // The base first, as the virtual joint by which MoveIt's robots stand in the world.
  std::vector<PlannedMultiDofJoint> multi_dof_joints;
};

// Who may touch whom: links and objects by name, each name once, a square matrix.
struct AllowedMatrix {
  std::vector<std::string> names;
  std::vector<std::vector<bool>> allowed;
  std::vector<std::string> by_default;  // those that may touch whatever is not in the matrix
};

struct PlanningScene {
  std::string name;        // of the world
  std::string robot_name;  // of the robot's description; empty: no robot
  std::vector<PlannedObject> objects;
  PlannedRobotState robot_state;
  AllowedMatrix allowed;
  std::vector<std::string> warnings;  // what a planning scene says otherwise, or not at all
};

// Names of one matrix: its text then has some 25 MB. Robots have some hundred links.
inline constexpr std::size_t kMostAllowedNames = 2'048;

// The objects of a snapshot, by name: every part that collision checking sees. ResourceExhausted
// GEOMETRY_TOO_LARGE when their meshes have more than `max_triangles` together.
absl::StatusOr<PlanningScene> SceneOf(const collision::WorldSnapshot& snapshot,
                                      std::int64_t max_triangles,
                                      const GoOn& go_on = absl::OkStatus);

// Adds what a scene says beside its objects: the robot's state and base (`robot` may be null) and
// which pairs may collide. Links that the robot does not check against each other may. What another
// robot holds stands free then, where it is. Errors are those of AllowedMatrixOf.
absl::Status AddRobotAndRules(const collision::WorldSnapshot& snapshot,
                              const collision::WorldRobot* robot, PlanningScene& scene,
                              const GoOn& go_on = absl::OkStatus);

// Takes out what robots hold, with a warning: where there are objects alone it would stand in
// the robot's way.
void LeaveOutAttached(PlanningScene& scene);

// The matrix alone; warnings of rules that it cannot say. ResourceExhausted EXPORT_TOO_LARGE when
// it would have more than kMostAllowedNames.
absl::StatusOr<AllowedMatrix> AllowedMatrixOf(const collision::WorldSnapshot& snapshot,
                                              const collision::WorldRobot* robot,
                                              std::vector<std::string>& warnings,
                                              const GoOn& go_on = absl::OkStatus);

}  // namespace cwm::server
