#include "tests/benchmarks/live/bench_robot.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <span>
#include <utility>

#include "clients/formats/robot_files.h"
#include "collision/robot/kinematics.h"
#include "collision/robot/srdf.h"
#include "collision/robot/urdf.h"
#include "tests/benchmarks/live/live_scenes.h"
#include "tests/benchmarks/running_server.h"
#include "tests/collision/robot/panda_files.h"

namespace cwm::benchmarks {
namespace {

// A shoulder that turns about z, an upper arm and a forearm that bend, and a hand.
constexpr char kArmUrdf[] = R"(<robot name="arm">
  <link name="base"><collision><origin xyz="0 0 0.1"/>
    <geometry><cylinder radius="0.07" length="0.2"/></geometry></collision></link>
  <link name="upper"><collision><origin xyz="0 0 0.2"/>
    <geometry><cylinder radius="0.05" length="0.4"/></geometry></collision></link>
  <link name="fore"><collision><origin xyz="0 0 0.18"/>
    <geometry><cylinder radius="0.04" length="0.36"/></geometry></collision></link>
  <link name="hand"><collision><origin xyz="0 0 0.06"/>
    <geometry><box size="0.06 0.16 0.12"/></geometry></collision></link>
  <joint name="turn" type="revolute"><parent link="base"/><child link="upper"/>
    <origin xyz="0 0 0.25"/><axis xyz="0 0 1"/>
    <limit lower="-2.9" upper="2.9" velocity="2" effort="80"/></joint>
  <joint name="bend" type="revolute"><parent link="upper"/><child link="fore"/>
    <origin xyz="0 0 0.42"/><axis xyz="0 1 0"/>
    <limit lower="-2.9" upper="2.9" velocity="2" effort="80"/></joint>
  <joint name="wrist" type="revolute"><parent link="fore"/><child link="hand"/>
    <origin xyz="0 0 0.4"/><axis xyz="0 1 0"/>
    <limit lower="-2.9" upper="2.9" velocity="2" effort="80"/></joint>
</robot>)";

absl::StatusOr<std::shared_ptr<const collision::RobotModel>> ModelOf(
    const BenchRobot& robot, const collision::MeshSource& meshes) {
  const auto description = collision::ReadUrdf(robot.urdf, meshes);
  if (!description.ok()) return description.status();
  if (robot.srdf.empty()) return collision::MakeRobotModel(*description, nullptr);
  const auto semantic = collision::ReadSrdf(robot.srdf, *description);
  if (!semantic.ok()) return semantic.status();
  return collision::MakeRobotModel(*description, &*semantic);
}

// The robot's default state with the named values.
std::vector<double> StateOf(const collision::RobotModel& model,
                            const std::map<std::string, double>& values) {
  std::vector<double> state = collision::DefaultVariables(model);
  for (std::size_t i = 0; i < state.size(); ++i) {
    const auto value = values.find(model.variables[i].name);
    if (value != values.end()) state[i] = value->second;
  }
  return state;
}

absl::StatusOr<BenchRobot> ReadPanda(const collision::testing::PandaFiles& files) {
  BenchRobot robot{
      .name = "panda", .urdf = files.urdf, .srdf = files.srdf, .spheres = files.spherized_urdf};
  for (const std::string& uri : formats::CollisionMeshUris(files.urdf)) {
    auto bytes = files.meshes(uri);
    if (!bytes.ok()) return bytes.status();
    robot.meshes.push_back({uri, *std::move(bytes)});
  }
  auto model = ModelOf(robot, files.meshes);
  if (!model.ok()) return model.status();
  robot.model = *std::move(model);
  // The state "ready" of its SRDF, a little lower.
  constexpr double kQuarter = std::numbers::pi / 4;
  robot.ready = StateOf(*robot.model, {{"panda_joint1", 0},
                                       {"panda_joint2", -kQuarter + 0.35},
                                       {"panda_joint3", 0},
                                       {"panda_joint4", -3 * kQuarter + 0.1},
                                       {"panda_joint5", 0},
                                       {"panda_joint6", 2 * kQuarter + 0.25},
                                       {"panda_joint7", kQuarter},
                                       {"panda_finger_joint1", 0.02},
                                       {"panda_finger_joint2", 0.02}});
  const auto hand = robot.model->FindLink("panda_hand");
  if (!hand) return absl::NotFoundError("the Panda has no link panda_hand");
  robot.hand_link = static_cast<std::size_t>(*hand);
  return robot;
}

absl::StatusOr<BenchRobot> ReadArm() {
  BenchRobot robot{.name = "arm", .urdf = kArmUrdf};
  auto model = ModelOf(robot, {});
  if (!model.ok()) return model.status();
  robot.model = *std::move(model);
  robot.ready = StateOf(*robot.model, {{"bend", 1.4}, {"wrist", 1.2}});
  robot.hand_link = robot.model->links.size() - 1;
  return robot;
}

}  // namespace

absl::StatusOr<BenchRobot> ReadBenchRobot() {
  const auto files = collision::testing::ReadPandaFiles();
  return files ? ReadPanda(*files) : ReadArm();
}

Pose RobotBase() {
  return MakePose({1.3, 0, kTableTop_m},
                  Quaternion(Eigen::AngleAxisd(std::numbers::pi, Vector3::UnitZ())));
}

perception::SimulatedRobot SimulateRobot(const BenchRobot& robot,
                                         perception::JointTrajectory trajectory) {
  perception::SimulatedRobot simulated;
  simulated.name = robot.name;
  for (const collision::ModelLink& link : robot.model->links) {
    perception::SimulatedObject& body = simulated.links.emplace_back();
    body.name = link.name;
    for (const collision::CollisionGeometry& geometry : link.collisions) {
      body.parts.push_back({.X_FS = geometry.X_LG, .shape = geometry.shape});
    }
  }
  for (const collision::Variable& variable : robot.model->variables) {
    simulated.variables.push_back(variable.name);
  }
  simulated.link_poses = [model = robot.model](std::span<const double> values) {
    std::vector<Pose> X_WL(model->links.size());
    collision::LinkPoses(*model, RobotBase(), values, X_WL);
    return X_WL;
  };
  simulated.trajectory = std::move(trajectory);
  return simulated;
}

perception::JointTrajectory SweepingTrajectory(const BenchRobot& robot, double rest_s,
                                               double duration_s, double speed_m_s) {
  constexpr double kAmplitude_rad = 0.7;
  constexpr double kStep_s = 0.05;  // between the knots
  std::vector<Pose> X_WL(robot.model->links.size());
  collision::LinkPoses(*robot.model, RobotBase(), robot.ready, X_WL);
  const double reach_m =
      (X_WL[robot.hand_link].translation() - RobotBase().translation()).head<2>().norm();
  const double rate_rad_s = speed_m_s / (reach_m * kAmplitude_rad);
  perception::JointTrajectory trajectory;
  for (double time_s = 0; time_s <= duration_s + kStep_s; time_s += kStep_s) {
    std::vector<double> row = robot.ready;
    row[0] += kAmplitude_rad * std::sin(rate_rad_s * std::max(0.0, time_s - rest_s));
    trajectory.times_s.push_back(time_s);
    trajectory.rows.push_back(std::move(row));
  }
  return trajectory;
}

absl::Status LoadBenchRobot(const client::Connection& connection, const std::string& world,
                            const BenchRobot& robot, const std::vector<double>& state) {
  v1::LoadRobotHeader header;
  header.set_world(world);
  header.set_name(robot.name);
  header.set_urdf(robot.urdf);
  if (!robot.srdf.empty()) header.set_srdf(robot.srdf);
  if (!robot.spheres.empty()) header.set_spheres(robot.spheres);
  SetPose(RobotBase(), header.mutable_x_world_base());
  for (std::size_t i = 0; i < state.size(); ++i) {
    v1::VariableValue& value = *header.mutable_initial_state()->add_values();
    value.set_variable(robot.model->variables[i].name);
    value.set_value(state[i]);
  }
  if (auto loaded = client::LoadRobot(connection, header, robot.meshes); !loaded.ok()) {
    return loaded.status();
  }
  // It stands on the table, which its base touches.
  v1::ApplyChangesRequest request;
  request.set_world(world);
  v1::NamedPair& pair = *request.add_changes()->mutable_allow()->mutable_pair();
  pair.mutable_a()->set_name(robot.name);
  pair.mutable_a()->set_link(robot.model->links.front().name);
  pair.mutable_b()->set_name("*");
  return connection.Call(&v1::WorldService::Stub::ApplyChanges, connection.worlds(), request)
      .status();
}

}  // namespace cwm::benchmarks
