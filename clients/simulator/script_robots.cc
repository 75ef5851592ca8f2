#include <algorithm>
#include <filesystem>
#include <memory>
#include <utility>

#include "absl/strings/str_cat.h"
#include "clients/formats/file_bytes.h"
#include "clients/formats/robot_files.h"
#include "clients/simulator/pose_yaml.h"
#include "clients/simulator/script_yaml.h"
#include "collision/robot/kinematics.h"
#include "collision/robot/robot_model.h"
#include "collision/robot/urdf.h"

namespace cwm::simulator {
namespace {

using collision::RobotModel;
using perception::JointStateStream;
using perception::JointTrajectory;
using perception::SimulatedRobot;
using perception::TimeInterval;

absl::StatusOr<RobotFiles> ReadRobotFiles(const YamlNode& node) {
  const auto urdf = node["urdf"].ReadText();
  if (!urdf.ok()) return urdf.status();
  const auto folder = std::filesystem::path(node.file()).parent_path();
  const auto absolute = [&](const std::string& path) {
    return std::filesystem::absolute(folder / path).lexically_normal().string();
  };
  RobotFiles files{.urdf_path = absolute(*urdf)};
  const YamlNode packages = node["packages"];
  if (packages.present() && !packages.is_list()) return packages.Error("must be a list of folders");
  for (std::size_t i = 0; i < packages.size(); ++i) {
    const auto package = packages[i].ReadText();
    if (!package.ok()) return package.status();
    files.package_folders.push_back(absolute(*package));
  }
  const auto X_WB = ReadPose(node["pose"]);
  if (!X_WB.ok()) return X_WB.status();
  files.X_WB = *X_WB;
  return files;
}

absl::StatusOr<std::shared_ptr<const RobotModel>> LoadRobot(const RobotFiles& files) {
  const auto xml = formats::ReadFileBytes(files.urdf_path);
  if (!xml.ok()) return xml.status();
  const formats::RobotFolders folders{
      .urdf_folder = std::filesystem::path(files.urdf_path).parent_path().string(),
      .package_folders = files.package_folders};
  auto description =
      collision::ReadUrdf(*xml, [&](std::string_view uri) -> absl::StatusOr<std::string> {
        const auto path = formats::FindMeshFile(uri, folders);
        if (!path.ok()) return path.status();
        return formats::ReadFileBytes(*path);
      });
  if (!description.ok()) return description.status();
  return collision::MakeRobotModel(*std::move(description), nullptr);
}

// One body per link, with its collision geometry.
std::vector<perception::SimulatedObject> LinkBodies(const RobotModel& model) {
  std::vector<perception::SimulatedObject> bodies;
  for (const collision::ModelLink& link : model.links) {
    perception::SimulatedObject body{.name = link.name};
    for (const collision::CollisionGeometry& geometry : link.collisions) {
      body.parts.push_back({.X_FS = geometry.X_LG, .shape = geometry.shape});
    }
    bodies.push_back(std::move(body));
  }
  return bodies;
}

// The variables that the rows of a trajectory hold: those under "joints", or all.
absl::StatusOr<std::vector<std::size_t>> ReadJoints(const YamlNode& node,
                                                    const SimulatedRobot& robot) {
  std::vector<std::size_t> joints;
  if (!node.present()) {
    for (std::size_t i = 0; i < robot.variables.size(); ++i) joints.push_back(i);
    return joints;
  }
  if (!node.is_list()) return node.Error("must be a list of joints");
  for (std::size_t i = 0; i < node.size(); ++i) {
    const auto joint = ReadNameOf(node[i], absl::StrCat("joint of ", robot.name), robot.variables);
    if (!joint.ok()) return joint.status();
    if (std::count(joints.begin(), joints.end(), *joint) > 0) {
      return node[i].Error("must not appear twice");
    }
    joints.push_back(*joint);
  }
  return joints;
}

absl::StatusOr<JointTrajectory> ReadTrajectory(const YamlNode& node, const RobotModel& model,
                                               const SimulatedRobot& robot, double duration_s) {
  const std::vector<double> rest = collision::DefaultVariables(model);
  const YamlNode list = node["trajectory"];
  if (!list.present()) return JointTrajectory{.times_s = {0}, .rows = {rest}};
  const auto joints = ReadJoints(node["joints"], robot);
  if (!joints.ok()) return joints.status();
  const auto times_s = ReadTimes(list, duration_s);
  if (!times_s.ok()) return times_s.status();
  JointTrajectory trajectory{.times_s = *times_s};
  for (std::size_t i = 0; i < list.size(); ++i) {
    absl::Status status = list[i].CheckKeys({"time_s", "values"});
    if (!status.ok()) return status;
    const YamlNode values_node = list[i]["values"];
    const auto values = values_node.ReadNumbers(joints->size());
    if (!values.ok()) return values.status();
    std::vector<double> row = rest;
    for (std::size_t j = 0; j < joints->size(); ++j) row[(*joints)[j]] = (*values)[j];
    if (const auto outside = collision::OutOfLimits(model, row)) {
      const collision::Variable& variable = model.variables[static_cast<std::size_t>(*outside)];
      return values_node.Error(
          absl::StrCat("puts ", variable.name, " at ", row[static_cast<std::size_t>(*outside)],
                       ", must be within its limits, ", variable.lower, " to ", variable.upper));
    }
    trajectory.rows.push_back(std::move(row));
  }
  return trajectory;
}

absl::StatusOr<TimeInterval> ReadInterval(const YamlNode& node, double duration_s) {
  const auto begin = ReadTime(node["from_s"], duration_s);
  if (!begin.ok()) return begin.status();
  const auto end = ReadTime(node["to_s"], duration_s);
  if (!end.ok()) return end.status();
  if (*end <= *begin) return node["to_s"].Error("must be later than from_s");
  return TimeInterval{.begin_s = *begin, .end_s = *end};
}

absl::Status ReadGaps(const YamlNode& node, double duration_s, JointStateStream& stream) {
  for (const char* key : {"missing", "late"}) {
    if (node[key].present() && !node[key].is_list()) return node[key].Error("must be a list");
  }
  for (std::size_t i = 0; i < node["missing"].size(); ++i) {
    const YamlNode entry = node["missing"][i];
    if (absl::Status status = entry.CheckKeys({"from_s", "to_s"}); !status.ok()) return status;
    const auto interval = ReadInterval(entry, duration_s);
    if (!interval.ok()) return interval.status();
    stream.missing.push_back(*interval);
  }
  for (std::size_t i = 0; i < node["late"].size(); ++i) {
    const YamlNode entry = node["late"][i];
    absl::Status status = entry.CheckKeys({"from_s", "to_s", "by_s"});
    if (!status.ok()) return status;
    const auto interval = ReadInterval(entry, duration_s);
    if (!interval.ok()) return interval.status();
    const auto by_s = ReadPositive(entry["by_s"]);
    if (!by_s.ok()) return by_s.status();
    stream.late.push_back({.during = *interval, .by_s = *by_s});
  }
  return absl::OkStatus();
}

absl::StatusOr<JointStateStream> ReadStates(const YamlNode& node, double duration_s) {
  JointStateStream stream;
  if (!node.present()) return stream;
  absl::Status status =
      node.CheckKeys({"rate_hz", "clock_offset_s", "latency_s", "missing", "late"});
  if (!status.ok()) return status;
  const auto rate = ReadRateOr(node["rate_hz"], stream.rate_hz);
  if (!rate.ok()) return rate.status();
  stream.rate_hz = *rate;
  const auto offset = ReadNumberOr(node["clock_offset_s"], 0);
  if (!offset.ok()) return offset.status();
  stream.clock_offset_s = *offset;
  const auto latency = ReadSecondsOr(node["latency_s"], 0);
  if (!latency.ok()) return latency.status();
  stream.latency_s = *latency;
  if (status = ReadGaps(node, duration_s, stream); !status.ok()) return status;
  return stream;
}

absl::Status ReadRobot(const YamlNode& node, ScriptFile& file) {
  absl::Status status =
      node.CheckKeys({"name", "urdf", "packages", "pose", "joints", "trajectory", "states"});
  if (!status.ok()) return status;
  SimulatedRobot robot;
  const auto name = ReadNewName(node["name"], RobotNames(file.script));
  if (!name.ok()) return name.status();
  robot.name = *name;
  auto files = ReadRobotFiles(node);
  if (!files.ok()) return files.status();
  const auto model = LoadRobot(*files);
  if (!model.ok()) {
    return node["urdf"].Error(absl::StrCat("cannot be used: ", model.status().message()));
  }
  robot.links = LinkBodies(**model);
  for (const collision::Variable& variable : (*model)->variables) {
    robot.variables.push_back(variable.name);
  }
  robot.link_poses = [model = *model, X_WB = files->X_WB](std::span<const double> values) {
    std::vector<Pose> X_WL(model->links.size());
    collision::LinkPoses(*model, X_WB, values, X_WL);
    return X_WL;
  };
  auto trajectory = ReadTrajectory(node, **model, robot, file.script.duration_s);
  if (!trajectory.ok()) return trajectory.status();
  robot.trajectory = *std::move(trajectory);
  auto states = ReadStates(node["states"], file.script.duration_s);
  if (!states.ok()) return states.status();
  robot.states = *std::move(states);
  file.script.robots.push_back(std::move(robot));
  file.robots.push_back(*std::move(files));
  return absl::OkStatus();
}

}  // namespace

absl::Status ReadRobots(const YamlNode& node, ScriptFile& file) {
  if (!node.present()) return absl::OkStatus();
  if (node.size() == 0 || node.size() > kMaxRobots) {
    return node.Error(absl::StrCat("must be a list of 1 to ", kMaxRobots, " robots"));
  }
  for (std::size_t i = 0; i < node.size(); ++i) {
    if (absl::Status status = ReadRobot(node[i], file); !status.ok()) return status;
  }
  return absl::OkStatus();
}

}  // namespace cwm::simulator
