// A world of the server for planning, and the queries about it.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "clients/cpp/connection.h"
#include "clients/formats/scene_file.h"
#include "clients/planner/joint_space.h"
#include "clients/planner/state_query.h"
#include "cwm/v1/world.pb.h"

namespace cwm::planner {

// The facts of one revision.
struct PlanningWorld {
  std::string name;
  std::string world_uid;
  std::int64_t revision = 0;
  v1::Robot robot;
  std::vector<std::string> other_robots;
  std::vector<v1::PairRule> rules;
};

// The world with the named robot, or with its only robot if the name is empty.
absl::StatusOr<PlanningWorld> ReadPlanningWorld(const client::Connection& connection,
                                                const std::string& world, const std::string& robot);

// The environment of the queries: the robot in the world, or in a scene instead.
struct PlanningEnvironment {
  google::protobuf::RepeatedPtrField<v1::Change> overlay;  // that the scene makes of the world
  std::vector<std::string> ignored_robots;
  v1::Robot robot;                    // with its state there
  std::vector<std::string> warnings;  // about the scene
};

PlanningEnvironment EnvironmentOfWorld(const PlanningWorld& world);

// The scene replaces everything in the world but the robot: objects, other robots, pair rules. It
// is an overlay of the queries that nobody else sees. Its meshes are stored on the server.
absl::StatusOr<PlanningEnvironment> EnvironmentOfScene(const client::Connection& connection,
                                                       const PlanningWorld& world,
                                                       const formats::SceneFile& scene);

// A query about states of the group, over a stream of the connection. Other joints and the base are
// as in `start`, whose values for joints of the group are ignored.
absl::StatusOr<StateQuery> MakeStateQuery(const client::Connection& connection,
                                          const PlanningWorld& world,
                                          const PlanningEnvironment& environment,
                                          const std::string& group,
                                          const std::vector<Joint>& joints,
                                          const v1::SetRobotState& start);

}  // namespace cwm::planner
