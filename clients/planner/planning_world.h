// A world of the server as a plan finds it, and what is asked of it.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "clients/cpp/connection.h"
#include "clients/formats/scene_file.h"
#include "clients/planner/joint_space.h"
#include "cwm/v1/query.pb.h"
#include "cwm/v1/world.pb.h"

namespace cwm::planner {

// Of one revision.
struct PlanningWorld {
  std::string name;
  std::string world_uid;
  std::int64_t revision = 0;
  v1::Robot robot;
  std::vector<std::string> other_robots;
  std::vector<v1::PairRule> rules;
};

// With the robot of the name, or the only one where the name is empty.
absl::StatusOr<PlanningWorld> ReadPlanningWorld(const client::Connection& connection,
                                                const std::string& world, const std::string& robot);

// What the plan asks of: the robot in the world, or in a scene alone.
struct Surroundings {
  v1::QueryOptions options;           // revision, overlay, who is left out
  v1::Robot robot;                    // with the state that it has there
  std::vector<std::string> warnings;  // of the scene
};

Surroundings AsItIs(const PlanningWorld& world);

// The scene takes the place of all that the world has beside the robot: objects, other robots,
// rules of pairs. Nobody else sees it: it is laid over the questions. Its meshes are stored with
// the server.
absl::StatusOr<Surroundings> SceneAlone(const client::Connection& connection,
                                        const PlanningWorld& world,
                                        const formats::SceneFile& scene);

// Of states of the group, whose rows are to be filled in. Other joints and the base are as in
// `start`, of which what the group has does not count.
v1::CheckCollisionsRequest QuestionOf(const PlanningWorld& world, const Surroundings& surroundings,
                                      const std::string& group, const std::vector<Joint>& joints,
                                      const v1::SetRobotState& start);

}  // namespace cwm::planner
