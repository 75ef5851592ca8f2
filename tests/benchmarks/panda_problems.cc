#include "tests/benchmarks/panda_problems.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <random>
#include <sstream>

#include "clients/formats/scene_file.h"
#include "collision/query/query.h"
#include "collision/robot/srdf.h"
#include "collision/robot/urdf.h"
#include "tests/collision/robot/panda_files.h"
#include "tests/support/outside_data.h"

namespace cwm::benchmarks {
namespace {

using collision::Change;

std::string TextOf(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

Pose ToPose(const formats::ScenePose& pose) {
  const auto& [x, y, z, w] = pose.orientation_xyzw;
  return Eigen::Translation3d(pose.position_m[0], pose.position_m[1], pose.position_m[2]) *
         Eigen::Quaterniond(w, x, y, z);
}

struct SetShape {
  void operator()(const formats::SceneBox& b) const {
    shape = Box{{b.size_m[0], b.size_m[1], b.size_m[2]}};
  }
  void operator()(const formats::SceneSphere& s) const { shape = Sphere{s.radius_m}; }
  void operator()(const formats::SceneCylinder& c) const {
    shape = Cylinder{c.radius_m, c.height_m};
  }
  void operator()(const formats::SceneCone& c) const { shape = Cone{c.radius_m, 0, c.height_m}; }
  void operator()(const formats::SceneHalfSpace&) const { shape = HalfSpace{}; }
  void operator()(const formats::MeshFile&) const {
    throw std::runtime_error("no problem of MotionBenchMaker has a mesh");
  }

  Shape& shape;
};

std::shared_ptr<const collision::WorldSnapshot> WorldOf(const formats::SceneFile& scene) {
  std::vector<Change> changes;
  for (const formats::SceneObject& object : scene.objects) {
    collision::PutObject put;
    put.name = object.id;
    std::ranges::replace(put.name, ' ', '_');
    put.X_WO = ToPose(object.pose);
    std::vector<Placed<>> shapes;
    for (const formats::SceneShape& primitive : object.shapes) {
      Placed<>& placed = shapes.emplace_back();
      placed.X_FS = ToPose(primitive.pose);
      std::visit(SetShape{placed.shape}, primitive.shape);
    }
    put.geometry = collision::BodyFromShapes(std::move(shapes)).geometry;
    changes.push_back({.what = std::move(put), .expected_object_revision = {}});
  }
  auto world = collision::Apply(std::make_shared<const collision::WorldSnapshot>(), changes);
  return world.ok() ? *world : nullptr;
}

// The values of the arm's joints, in its order.
std::vector<double> InOrder(const collision::JointGroup& arm,
                            const std::map<std::string, double>& values) {
  std::vector<double> row;
  for (const std::string& joint : arm.joints) row.push_back(values.at(joint));
  return row;
}

void ReadRequest(const std::filesystem::path& path, const collision::JointGroup& arm,
                 PandaProblem& problem) {
  const YAML::Node request = YAML::Load(TextOf(path));
  std::map<std::string, double> start, goal;
  const YAML::Node state = request["start_state"]["joint_state"];
  for (std::size_t k = 0; k < state["name"].size(); ++k) {
    start[state["name"][k].as<std::string>()] = state["position"][k].as<double>();
  }
  for (const YAML::Node& joint : request["goal_constraints"][0]["joint_constraints"]) {
    goal[joint["joint_name"].as<std::string>()] = joint["position"].as<double>();
  }
  problem.start = InOrder(arm, start);
  problem.goal = InOrder(arm, goal);
}

std::shared_ptr<const collision::RobotGeometry> ReadPanda() {
  const auto files = collision::testing::ReadPandaFiles();
  if (!files) return nullptr;
  const auto description = collision::ReadUrdf(files->urdf, files->meshes);
  if (!description.ok()) return nullptr;
  const auto semantic = collision::ReadSrdf(files->srdf, *description);
  const auto spherized = collision::ReadUrdf(files->spherized_urdf, files->meshes);
  if (!semantic.ok() || !spherized.ok()) return nullptr;
  const auto model = collision::MakeRobotModel(*description, &*semantic);
  if (!model.ok()) return nullptr;
  auto spheres = collision::SphereModelFromUrdf(*spherized, **model);
  if (!spheres.ok()) return nullptr;
  return collision::PrepareRobot(*model, *std::move(spheres));
}

}  // namespace

std::optional<PandaProblems> ReadPandaProblems() {
  const auto folder = cwm::testing::OutsideData("motion_bench_maker/panda/problems");
  PandaProblems all;
  all.robot = ReadPanda();
  if (!folder || !all.robot) return std::nullopt;
  all.arm = all.robot->model->FindGroup("panda_arm");
  std::vector<std::filesystem::path> scenes;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(*folder)) {
    if (entry.path().filename().string().starts_with("scene")) scenes.push_back(entry.path());
  }
  std::ranges::sort(scenes);
  for (const std::filesystem::path& path : scenes) {
    const std::string number = path.stem().string().substr(5);
    const auto scene = formats::ParseScene(TextOf(path), path.string());
    if (!scene.ok()) return std::nullopt;
    PandaProblem& problem = all.problems.emplace_back();
    problem.name = path.parent_path().filename().string() + "/" + number;
    problem.world = WorldOf(*scene);
    if (!problem.world) return std::nullopt;
    ReadRequest(path.parent_path() / ("request" + number + ".yaml"), *all.arm, problem);
  }
  return all;
}

std::vector<double> RandomStates(const PandaProblems& all, const PandaProblem& problem,
                                 std::size_t count, std::uint64_t seed) {
  constexpr double kAroundGoal_rad = 0.1;
  std::mt19937_64 random(seed);
  std::vector<double> rows;
  for (std::size_t k = 0; k < count; ++k) {
    for (std::size_t j = 0; j < all.arm->variables.size(); ++j) {
      const auto variable = static_cast<std::size_t>(all.arm->variables[j]);
      const auto& [lower, upper] = std::pair(all.robot->model->variables[variable].lower,
                                             all.robot->model->variables[variable].upper);
      const double low = k % 2 == 0 ? lower : std::max(lower, problem.goal[j] - kAroundGoal_rad);
      const double high = k % 2 == 0 ? upper : std::min(upper, problem.goal[j] + kAroundGoal_rad);
      rows.push_back(std::uniform_real_distribution<double>(low, high)(random));
    }
  }
  return rows;
}

}  // namespace cwm::benchmarks
