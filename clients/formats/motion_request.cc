#include "clients/formats/motion_request.h"

#include <set>
#include <utility>

#include "absl/strings/str_cat.h"
#include "clients/formats/format_error.h"
#include "clients/formats/scene_yaml.h"

namespace cwm::formats {
namespace {

// An error if there are constraints that a joint-space planner cannot satisfy.
absl::Status CheckAbsent(const FieldReader& reader, const YamlNode& constraints,
                         std::initializer_list<const char*> lists) {
  for (const char* name : lists) {
    const YamlNode list = constraints[name];
    if (list.present() && !(list.is_list() && list.size() == 0)) {
      return reader.Error(list, "must be empty: joints alone are planned to");
    }
  }
  return absl::OkStatus();
}

absl::StatusOr<std::vector<SceneJoint>> ReadGoal(const FieldReader& reader, const YamlNode& goals) {
  if (!goals.is_list() || goals.size() != 1) {
    return reader.Error(goals, goals.is_list()
                                   ? absl::StrCat("must hold one goal, holds ", goals.size())
                                   : std::string("must be a list of one goal"));
  }
  const YamlNode goal = goals[std::size_t{0}];
  const absl::Status others = CheckAbsent(
      reader, goal, {"position_constraints", "orientation_constraints", "visibility_constraints"});
  if (!others.ok()) return others;
  const YamlNode constraints = goal["joint_constraints"];
  if (!constraints.is_list() || constraints.size() == 0) {
    return reader.Error(constraints, "must be a list of joints and their positions");
  }
  std::vector<SceneJoint> joints;
  std::set<std::string> names;
  for (std::size_t i = 0; i < constraints.size(); ++i) {
    auto name = reader.Name(constraints[i]["joint_name"]);
    if (!name.ok()) return name.status();
    const auto position = reader.Number(constraints[i]["position"]);
    if (!position.ok()) return position.status();
    if (!names.insert(*name).second) {
      return reader.Error(constraints[i]["joint_name"], "must not appear twice");
    }
    joints.push_back({*std::move(name), *position});
  }
  return joints;
}

absl::StatusOr<MotionRequest> ReadRequest(const YamlNode& root, const FieldReader& reader) {
  MotionRequest request;
  if (root["group_name"].present()) {
    auto group = reader.Scalar(root["group_name"]);
    if (!group.ok()) return group.status();
    request.group = *std::move(group);
  }
  auto goal = ReadGoal(reader, root["goal_constraints"]);
  if (!goal.ok()) return goal.status();
  request.goal = *std::move(goal);
  const absl::Status path = CheckAbsent(reader, root["path_constraints"],
                                        {"joint_constraints", "position_constraints",
                                         "orientation_constraints", "visibility_constraints"});
  if (!path.ok()) return path;
  const auto frames = SceneFrames::Read(reader, root["fixed_frame_transforms"], "");
  if (!frames.ok()) return frames.status();
  auto start = ReadRobotState(reader, root["start_state"], *frames, request.warnings);
  if (!start.ok()) return start.status();
  request.start = *std::move(start);
  std::set<std::string> names;
  for (std::size_t i = 0; i < request.start.joints.size(); ++i) {
    if (names.insert(request.start.joints[i].name).second) continue;
    return reader.Error(root["start_state"]["joint_state"]["name"][i], "must not appear twice");
  }
  if (!request.start.attached.empty()) {
    request.warnings.push_back(
        "start_state.attached_collision_objects: left out, what the robot holds is the scene's");
  }
  if (const YamlNode time = root["allowed_planning_time"]; time.present()) {
    const auto time_s = reader.Number(time);
    if (!time_s.ok()) return time_s.status();
    if (*time_s < 0) return reader.Error(time, "must not be negative");
    if (*time_s > 0) request.allowed_time_s = *time_s;
  }
  return request;
}

}  // namespace

absl::StatusOr<MotionRequest> ParseMotionRequest(std::string_view yaml, const std::string& file) {
  try {  // yaml-cpp reports errors by exceptions, which are handled here
    const YAML::Node root = YAML::Load(std::string(yaml));
    return ReadRequest(YamlNode{root, "request"}, FieldReader(file, yaml.size()));
  } catch (const YAML::Exception& error) {
    return FileError(file, {"YAML", "", error.what()});
  }
}

}  // namespace cwm::formats
