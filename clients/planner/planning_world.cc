#include "clients/planner/planning_world.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "clients/cpp/world_stream.h"
#include "clients/scene/scene_import.h"

namespace cwm::planner {
namespace {

void SetExact(const PlanningWorld& world, v1::AtRevision* at) { at->set_exact(world.revision); }

// The names of all objects.
absl::StatusOr<std::vector<std::string>> ObjectsOf(const client::Connection& connection,
                                                   const PlanningWorld& world) {
  v1::ListObjectsRequest request;
  request.set_world(world.name);
  request.set_world_uid(world.world_uid);
  request.set_view(v1::OBJECT_VIEW_BASIC);
  SetExact(world, request.mutable_at_revision());
  std::vector<std::string> names;
  do {
    const auto page =
        connection.Call(&v1::WorldService::Stub::ListObjects, connection.worlds(), request);
    if (!page.ok()) return page.status();
    for (const v1::Object& object : page->objects()) names.push_back(object.name());
    request.set_page_token(page->next_page_token());
  } while (!request.page_token().empty());
  return names;
}

absl::Status ChooseRobot(const std::vector<v1::Robot>& robots, const std::string& name,
                         PlanningWorld& world) {
  std::vector<std::string> names;
  for (const v1::Robot& robot : robots) names.push_back(robot.name());
  const auto chosen = std::find(names.begin(), names.end(), name);
  if (!name.empty() && chosen == names.end()) {
    return absl::NotFoundError(absl::StrCat("no robot \"", name, "\" in the world, which has ",
                                            names.empty() ? "none" : absl::StrJoin(names, ", ")));
  }
  if (name.empty() && names.size() != 1) {
    return absl::NotFoundError(
        names.empty()
            ? "the world has no robot: `cwm robot load` it first"
            : absl::StrCat("--robot must say which: the world has ", absl::StrJoin(names, ", ")));
  }
  const std::size_t index = name.empty() ? 0 : static_cast<std::size_t>(chosen - names.begin());
  world.robot = robots[index];
  names.erase(names.begin() + static_cast<std::ptrdiff_t>(index));
  world.other_robots = std::move(names);
  return absl::OkStatus();
}

using Overlay = google::protobuf::RepeatedPtrField<v1::Change>;

void RemoveObject(const std::string& object, Overlay& overlay) {
  overlay.Add()->mutable_remove()->set_name(object);
}

void WithdrawAllowance(const v1::PairRule& rule, Overlay& overlay) {
  if (rule.allowed()) {
    v1::AllowCollision& allow = *overlay.Add()->mutable_allow();
    *allow.mutable_pair() = rule.pair();
    allow.set_withdraw(true);
  }
  if (rule.has_margin_m()) *overlay.Add()->mutable_margin()->mutable_pair() = rule.pair();
}

// Applies the changes to the robot's state, for joints that the plan does not set.
void ApplyState(const v1::SetRobotState& set, v1::Robot& robot) {
  for (const v1::VariableValue& value : set.joints().values()) {
    for (int i = 0; i < robot.variables_size() && i < robot.state_size(); ++i) {
      if (robot.variables(i).name() == value.variable()) robot.set_state(i, value.value());
    }
  }
}

}  // namespace

absl::StatusOr<PlanningWorld> ReadPlanningWorld(const client::Connection& connection,
                                                const std::string& world,
                                                const std::string& robot) {
  v1::GetWorldRequest get;
  get.set_world(world);
  const auto found = connection.Call(&v1::WorldService::Stub::GetWorld, connection.worlds(), get);
  if (!found.ok()) return found.status();
  PlanningWorld read{.name = world,
                     .world_uid = found->world_uid(),
                     .revision = found->revision(),
                     .robot = {},
                     .other_robots = {},
                     .rules = {found->pair_rules().begin(), found->pair_rules().end()}};
  v1::ListRobotsRequest request;
  request.set_world(world);
  request.set_world_uid(read.world_uid);
  SetExact(read, request.mutable_at_revision());
  std::vector<v1::Robot> robots;
  do {
    const auto page =
        connection.Call(&v1::RobotService::Stub::ListRobots, connection.robots(), request);
    if (!page.ok()) return page.status();
    robots.insert(robots.end(), page->robots().begin(), page->robots().end());
    request.set_page_token(page->next_page_token());
  } while (!request.page_token().empty());
  if (absl::Status status = ChooseRobot(robots, robot, read); !status.ok()) return status;
  return read;
}

PlanningEnvironment EnvironmentOfWorld(const PlanningWorld& world) {
  return {.overlay = {}, .ignored_robots = {}, .robot = world.robot, .warnings = {}};
}

absl::StatusOr<PlanningEnvironment> EnvironmentOfScene(const client::Connection& connection,
                                                       const PlanningWorld& world,
                                                       const formats::SceneFile& scene) {
  const auto import = scene::ConvertScene(connection, scene, {.robot = &world.robot});
  if (!import.ok()) return import.status();
  const auto objects = ObjectsOf(connection, world);
  if (!objects.ok()) return objects.status();
  PlanningEnvironment environment = EnvironmentOfWorld(world);
  environment.warnings = import->warnings;
  for (const std::string& object : *objects) RemoveObject(object, environment.overlay);
  for (const v1::PairRule& rule : world.rules) WithdrawAllowance(rule, environment.overlay);
  environment.ignored_robots = world.other_robots;
  for (const v1::Change& change : import->changes) {
    *environment.overlay.Add() = change;
    if (change.has_robot_state()) ApplyState(change.robot_state(), environment.robot);
  }
  return environment;
}

absl::StatusOr<StateQuery> MakeStateQuery(const client::Connection& connection,
                                          const PlanningWorld& world,
                                          const PlanningEnvironment& environment,
                                          const std::string& group,
                                          const std::vector<Joint>& joints,
                                          const v1::SetRobotState& start) {
  auto view = client::StreamWorld(
      connection, {.world = world.name, .world_uid = world.world_uid, .revision = world.revision},
      environment.overlay);
  if (!view.ok()) return view.status();
  StateQuery query{.world = *std::move(view),
                   .robot = {.robot = world.robot.name(), .group = group}};
  query.options.ignore = environment.ignored_robots;
  if (start.has_x_world_base()) query.robot.X_WB = client::ToIsometry(start.x_world_base());
  for (const v1::VariableValue& value : start.joints().values()) {
    const bool is_planned = std::any_of(joints.begin(), joints.end(), [&](const Joint& joint) {
      return joint.name == value.variable();
    });
    if (!is_planned) query.robot.base_state.values[value.variable()] = value.value();
  }
  return query;
}

}  // namespace cwm::planner
