// A robot's state and its allowed collisions of a planning scene in YAML.
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "clients/formats/format_error.h"
#include "clients/formats/scene_yaml.h"

namespace cwm::formats {
namespace {

absl::Status CheckCounts(const FieldReader& reader, const YamlNode& values, std::size_t actual,
                         std::size_t expected, const char* of_what) {
  if (actual == expected) return absl::OkStatus();
  return reader.Error(values, absl::StrCat("must hold one for each of ", expected, " ", of_what,
                                           ", holds ", actual));
}

absl::Status ReadJoints(const FieldReader& reader, const YamlNode& node, SceneRobotState& state) {
  const auto names = reader.Names(node["name"]);
  if (!names.ok()) return names.status();
  const YamlNode positions = node["position"];
  if (absl::Status status = reader.CheckList(positions); !status.ok()) return status;
  auto status = CheckCounts(reader, positions, positions.size(), names->size(), "names");
  if (!status.ok()) return status;
  for (std::size_t i = 0; i < names->size(); ++i) {
    const auto position = reader.Number(positions[i]);
    if (!position.ok()) return position.status();
    state.joints.push_back({(*names)[i], *position});
  }
  return absl::OkStatus();
}

absl::Status ReadMultiDofJoints(const FieldReader& reader, const YamlNode& node,
                                const SceneFrames& frames, SceneRobotState& state) {
  const auto names = reader.Names(node["joint_names"]);
  if (!names.ok()) return names.status();
  const YamlNode transforms = node["transforms"];
  if (absl::Status status = reader.CheckList(transforms); !status.ok()) return status;
  auto status = CheckCounts(reader, transforms, transforms.size(), names->size(), "joint_names");
  if (!status.ok()) return status;
  if (names->empty()) return absl::OkStatus();
  const auto frame = frames.Find(reader, node["header"]);
  if (!frame.ok()) return frame.status();
  for (std::size_t i = 0; i < names->size(); ++i) {
    const auto transform = reader.Transform(transforms[i]);
    if (!transform.ok()) return transform.status();
    state.multi_dof_joints.push_back({(*names)[i], ComposePoses(*frame, *transform)});
  }
  return absl::OkStatus();
}

absl::StatusOr<SceneAttachedObject> ReadAttached(const FieldReader& reader, const YamlNode& node,
                                                 const SceneFrames& frames,
                                                 std::vector<std::string>& warnings) {
  SceneAttachedObject attached;
  auto link = reader.Name(node["link_name"]);
  if (!link.ok()) return link.status();
  attached.link = *std::move(link);
  auto touch_links = reader.Names(node["touch_links"]);
  if (!touch_links.ok()) return touch_links.status();
  attached.touch_links = *std::move(touch_links);
  const YamlNode object_node = node["object"];
  auto object = ReadObject(reader, object_node, warnings);
  if (!object.ok()) return object.status();
  attached.object = *std::move(object);
  const YamlNode frame_id = object_node["header"]["frame_id"];
  attached.pose_is_in_link = frame_id.is_scalar() && frame_id.yaml.Scalar() == attached.link;
  if (attached.pose_is_in_link) return attached;
  const auto frame = frames.Find(reader, object_node["header"]);
  if (!frame.ok()) return frame.status();
  attached.object.pose = ComposePoses(*frame, attached.object.pose);
  return attached;
}

// Adds one warning with the first few pairs for which the matrix is not symmetric.
void WarnAboutAsymmetry(const SceneAllowedCollisions& collisions,
                        std::vector<std::string>& warnings) {
  constexpr std::size_t kShown = 5;
  std::vector<std::string> shown;
  std::size_t count = 0;
  const auto& allowed = collisions.allowed;
  for (std::size_t i = 0; i < allowed.size(); ++i) {
    for (std::size_t j = i + 1; j < allowed.size(); ++j) {
      if (allowed[i][j] == allowed[j][i] || ++count > kShown) continue;
      shown.push_back(
          absl::StrCat(Printable(collisions.names[i]), " and ", Printable(collisions.names[j])));
    }
  }
  if (count == 0) return;
  const std::string more = count > kShown ? absl::StrCat(" and ", count - kShown, " more") : "";
  warnings.push_back(absl::StrCat("allowed_collision_matrix: says two things of ",
                                  absl::StrJoin(shown, ", "), more,
                                  "; that in the row of the first is taken"));
}

absl::Status ReadMatrix(const FieldReader& reader, const YamlNode& node,
                        SceneAllowedCollisions& collisions) {
  const std::size_t count = collisions.names.size();
  if (absl::Status status = reader.CheckList(node); !status.ok()) return status;
  auto status = CheckCounts(reader, node, node.size(), count, "entry_names");
  if (!status.ok()) return status;
  for (std::size_t i = 0; i < count; ++i) {
    const YamlNode entry = node[i];
    const YamlNode row = entry.is_map() ? entry["enabled"] : entry;
    if (absl::Status list = reader.CheckList(row); !list.ok()) return list;
    status = CheckCounts(reader, row, row.size(), count, "entry_names");
    if (!status.ok()) return status;
    std::vector<bool>& allowed = collisions.allowed.emplace_back();
    for (std::size_t j = 0; j < count; ++j) {
      const auto value = reader.Bool(row[j]);
      if (!value.ok()) return value.status();
      allowed.push_back(*value);
    }
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<SceneRobotState> ReadRobotState(const FieldReader& reader, const YamlNode& node,
                                               const SceneFrames& frames,
                                               std::vector<std::string>& warnings) {
  SceneRobotState state;
  absl::Status status = ReadJoints(reader, node["joint_state"], state);
  if (!status.ok()) return status;
  status = ReadMultiDofJoints(reader, node["multi_dof_joint_state"], frames, state);
  if (!status.ok()) return status;
  const YamlNode attached = node["attached_collision_objects"];
  if (status = reader.CheckList(attached); !status.ok()) return status;
  for (std::size_t i = 0; i < attached.size(); ++i) {
    auto object = ReadAttached(reader, attached[i], frames, warnings);
    if (!object.ok()) return object.status();
    state.attached.push_back(*std::move(object));
  }
  return state;
}

absl::StatusOr<SceneAllowedCollisions> ReadAllowedCollisions(const FieldReader& reader,
                                                             const YamlNode& node,
                                                             std::vector<std::string>& warnings) {
  SceneAllowedCollisions collisions;
  auto names = reader.Names(node["entry_names"]);
  if (!names.ok()) return names.status();
  collisions.names = *std::move(names);
  if (auto status = ReadMatrix(reader, node["entry_values"], collisions); !status.ok()) {
    return status;
  }
  WarnAboutAsymmetry(collisions, warnings);
  const auto default_names = reader.Names(node["default_entry_names"]);
  if (!default_names.ok()) return default_names.status();
  const YamlNode values = node["default_entry_values"];
  if (absl::Status status = reader.CheckList(values); !status.ok()) return status;
  auto status =
      CheckCounts(reader, values, values.size(), default_names->size(), "default_entry_names");
  if (!status.ok()) return status;
  for (std::size_t i = 0; i < default_names->size(); ++i) {
    const auto value = reader.Bool(values[i]);
    if (!value.ok()) return value.status();
    collisions.defaults.emplace_back((*default_names)[i], *value);
  }
  return collisions;
}

}  // namespace cwm::formats
