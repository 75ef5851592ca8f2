#include "clients/scene/scene_robot.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "clients/formats/format_error.h"
#include "clients/scene/scene_objects.h"

namespace cwm::scene {
namespace {

namespace pb = cwm::v1;

// The child link of the joint; nullptr if there is no such joint.
const pb::RobotLink* LinkOn(const pb::Robot& robot, const std::string& joint) {
  for (const pb::RobotLink& link : robot.links()) {
    if (link.joint() == joint) return &link;
  }
  return nullptr;
}

void AddValue(const std::string& variable, double value, pb::SetRobotState& set) {
  pb::VariableValue& entry = *set.mutable_joints()->add_values();
  entry.set_variable(variable);
  entry.set_value(value);
}

// Adds a floating joint's values under the server's names of its variables.
void AddFloating(const formats::SceneMultiDofJoint& joint, pb::SetRobotState& set) {
  const auto& [x, y, z] = joint.transform.position_m;
  const auto& [qx, qy, qz, qw] = joint.transform.orientation_xyzw;
  AddValue(joint.name + "/trans_x", x, set);
  AddValue(joint.name + "/trans_y", y, set);
  AddValue(joint.name + "/trans_z", z, set);
  AddValue(joint.name + "/rot_x", qx, set);
  AddValue(joint.name + "/rot_y", qy, set);
  AddValue(joint.name + "/rot_z", qz, set);
  AddValue(joint.name + "/rot_w", qw, set);
}

void AddPlanar(const formats::SceneMultiDofJoint& joint, pb::SetRobotState& set) {
  const auto& q = joint.transform.orientation_xyzw;
  AddValue(joint.name + "/x", joint.transform.position_m[0], set);
  AddValue(joint.name + "/y", joint.transform.position_m[1], set);
  AddValue(joint.name + "/theta", 2 * std::atan2(q[2], q[3]), set);
}

// Ignored joints by reason.
struct IgnoredJoints {
  std::vector<std::string> unknown, fixed, following;

  void Warn(const std::string& field, const std::string& robot,
            std::vector<std::string>& warnings) const {
    const auto warn = [&](const std::vector<std::string>& joints, const std::string& why) {
      if (!joints.empty()) warnings.push_back(absl::StrCat(field, ": ", FormatNames(joints), why));
    };
    warn(unknown, absl::StrCat(": left out, ", robot, " has no such joints"));
    warn(fixed, absl::StrCat(": left out, ", robot, " has them fixed at 0"));
    warn(following, ": left out, they follow other joints");
  }
};

void SetJoint(const formats::SceneJoint& joint, const pb::Robot& robot, SceneState& state,
              IgnoredJoints& ignored) {
  const bool is_variable = std::any_of(robot.variables().begin(), robot.variables().end(),
                                       [&](const auto& v) { return v.name() == joint.name; });
  if (is_variable) return AddValue(joint.name, joint.position, state.set);
  const pb::RobotLink* link = LinkOn(robot, joint.name);
  if (link == nullptr) return ignored.unknown.push_back(joint.name);
  if (!link->follows().empty()) return ignored.following.push_back(joint.name);
  if (joint.position != 0) ignored.fixed.push_back(joint.name);
}

void SetMultiDofJoint(const formats::SceneMultiDofJoint& joint, const pb::Robot& robot,
                      SceneState& state, IgnoredJoints& ignored) {
  const pb::RobotLink* link = LinkOn(robot, joint.name);
  if (link != nullptr && link->joint_kind() == pb::JOINT_KIND_FLOATING) {
    return AddFloating(joint, state.set);
  }
  if (link != nullptr && link->joint_kind() == pb::JOINT_KIND_PLANAR) {
    return AddPlanar(joint, state.set);
  }
  if (link != nullptr || state.sets_base) return ignored.unknown.push_back(joint.name);
  *state.set.mutable_x_world_base() = ScenePoseToProto(joint.transform);
  state.sets_base = true;
}

}  // namespace

std::string FormatNames(const std::vector<std::string>& names) {
  constexpr std::size_t kShown = 5;
  const std::size_t shown = std::min(names.size(), kShown);
  std::string text = absl::StrJoin(
      names.begin(), names.begin() + static_cast<std::ptrdiff_t>(shown), ", ",
      [](std::string* out, const std::string& name) { *out += formats::Printable(name); });
  if (names.size() > shown) absl::StrAppend(&text, " and ", names.size() - shown, " more");
  return text;
}

bool HasLink(const pb::Robot& robot, const std::string& link) {
  return std::any_of(robot.links().begin(), robot.links().end(),
                     [&](const pb::RobotLink& known) { return known.name() == link; });
}

SceneState ConvertRobotState(const formats::SceneRobotState& scene, const pb::Robot& robot,
                             const std::string& field) {
  SceneState state;
  state.set.set_name(robot.name());
  IgnoredJoints ignored;
  for (const auto& joint : scene.joints) SetJoint(joint, robot, state, ignored);
  for (const auto& joint : scene.multi_dof_joints) {
    SetMultiDofJoint(joint, robot, state, ignored);
  }
  ignored.Warn(field, robot.name(), state.warnings);
  return state;
}

}  // namespace cwm::scene
