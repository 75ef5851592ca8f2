// Planning scenes: recognises the format, and reads a YAML scene as a whole.
#include <set>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "clients/formats/format_error.h"
#include "clients/formats/scene_file.h"
#include "clients/formats/scene_yaml.h"
#include "clients/formats/text_cursor.h"

namespace cwm::formats {
namespace {

// Adds one warning per kind with the links or objects that it concerns.
void WarnAboutPadding(const FieldReader& reader, const YamlNode& scene, const char* list,
                      const char* value, double neutral, std::vector<std::string>& warnings) {
  std::vector<std::string> links;
  const YamlNode entries = scene[list];
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const auto number = reader.Number(entries[i][value]);
    const auto link = reader.Name(entries[i]["link_name"]);
    if (number.ok() && *number == neutral) continue;
    links.push_back(link.ok() ? Printable(*link) : "a link without name");
  }
  if (links.empty()) return;
  warnings.push_back(absl::StrCat(list, " of ", absl::StrJoin(links, ", "),
                                  ": left out, robots are taken as they are"));
}

void WarnAboutOctomap(const YamlNode& world, std::vector<std::string>& warnings) {
  const YamlNode data = world["octomap"]["octomap"]["data"];
  const bool is_there = data.size() > 0 || (data.is_scalar() && !data.yaml.Scalar().empty());
  if (is_there) warnings.push_back("world.octomap: left out, only objects are read");
}

// Checks attached objects. `ids`: those of the list of objects. Each may be attached once; one
// without shapes must be an object of the scene.
absl::Status CheckAttached(const SceneFile& scene, std::set<std::string> ids,
                           const FieldReader& reader, const YamlNode& nodes) {
  std::set<std::string> with_shapes, attached;
  for (const SceneObject& object : scene.objects) with_shapes.insert(object.id);
  for (std::size_t i = 0; i < scene.robot_state.attached.size(); ++i) {
    const SceneObject& object = scene.robot_state.attached[i].object;
    const YamlNode id = nodes[i]["object"]["id"];
    if (!attached.insert(object.id).second) return reader.Error(id, "must not be attached twice");
    if (!object.shapes.empty() && !ids.insert(object.id).second) {
      return reader.Error(id, "must not appear twice");
    }
    if (object.shapes.empty() && with_shapes.count(object.id) == 0) {
      return reader.Error(
          id, "must have shapes, here or as the collision object of world.collision_objects");
    }
  }
  return absl::OkStatus();
}

absl::StatusOr<bool> ReadIsDiff(const FieldReader& reader, const YamlNode& node) {
  if (!node.present()) return false;
  const std::string word = node.is_scalar() ? absl::AsciiStrToLower(node.yaml.Scalar()) : "";
  if (word == "true" || word == "1") return true;
  if (word == "false" || word == "0") return false;
  return reader.Error(node, "must be true or false");
}

absl::StatusOr<SceneFile> ReadScene(const YamlNode& root, const FieldReader& reader,
                                    const SceneOptions& options) {
  SceneFile scene;
  const YamlNode list = root["world"]["collision_objects"];
  const YamlNode attached = root["robot_state"]["attached_collision_objects"];
  // A scene may have no objects, but a file without any part of a scene is not one.
  const bool is_scene = root["robot_state"].present() || root["allowed_collision_matrix"].present();
  if (!list.present() && !is_scene) return reader.Error(list, "is missing");
  if (absl::Status status = reader.CheckList(list); !status.ok()) return status;
  if (root["robot_model_name"].is_scalar()) {
    scene.robot_model_name = root["robot_model_name"].yaml.Scalar();
  }
  const auto is_diff = ReadIsDiff(reader, root["is_diff"]);
  if (!is_diff.ok()) return is_diff.status();
  scene.is_diff = *is_diff;
  const auto frames =
      SceneFrames::Read(reader, root["fixed_frame_transforms"], options.world_frame);
  if (!frames.ok()) return frames.status();
  std::set<std::string> ids;
  for (std::size_t i = 0; i < list.size(); ++i) {
    const auto operation = ReadOperation(reader, list[i]["operation"],
                                         scene.is_diff ? SceneKind::kDiff : SceneKind::kFull);
    if (!operation.ok()) return operation.status();
    if (*operation == SceneOperation::kRemove) {
      auto id = reader.Name(list[i]["id"]);
      if (!id.ok()) return id.status();
      if (!ids.insert(*id).second) return reader.Error(list[i]["id"], "must not appear twice");
      scene.removed.push_back(*std::move(id));
      continue;
    }
    auto object = ReadObject(reader, list[i], scene.warnings);
    if (!object.ok()) return object.status();
    if (!ids.insert(object->id).second) return reader.Error(list[i]["id"], "must not appear twice");
    const auto frame = frames->Find(reader, list[i]["header"]);
    if (!frame.ok()) return frame.status();
    object->pose = ComposePoses(*frame, object->pose);
    if (object->shapes.empty()) {
      scene.warnings.push_back(absl::StrCat(Printable(object->id), ": left out, it has no shapes"));
    } else {
      scene.objects.push_back(*std::move(object));
    }
  }
  auto state = ReadRobotState(reader, root["robot_state"], *frames, scene.warnings);
  if (!state.ok()) return state.status();
  scene.robot_state = *std::move(state);
  if (absl::Status status = CheckAttached(scene, std::move(ids), reader, attached); !status.ok()) {
    return status;
  }
  auto allowed = ReadAllowedCollisions(reader, root["allowed_collision_matrix"], scene.warnings);
  if (!allowed.ok()) return allowed.status();
  scene.allowed_collisions = *std::move(allowed);
  WarnAboutPadding(reader, root, "link_padding", "padding", 0, scene.warnings);
  WarnAboutPadding(reader, root, "link_scale", "scale", 1, scene.warnings);
  WarnAboutOctomap(root["world"], scene.warnings);
  return scene;
}

// True if the second line begins an object or ends the scene; no YAML file has such a second line.
bool IsTextScene(std::string_view bytes) {
  TextCursor cursor(bytes);
  cursor.NextLine();  // skips the name
  const auto second = cursor.NextLine();
  if (!second) return false;
  const auto words = SplitWords(*second);
  return !words.empty() && (words[0] == "*" || words[0] == ".");
}

}  // namespace

absl::StatusOr<SceneFrames> SceneFrames::Read(const FieldReader& reader, const YamlNode& transforms,
                                              const std::string& world_frame) {
  SceneFrames frames;
  for (const std::string& name : {std::string(), std::string("world"), world_frame}) {
    frames.frames_[name] = ScenePose{};
  }
  if (absl::Status status = reader.CheckList(transforms); !status.ok()) return status;
  for (std::size_t i = 0; i < transforms.size(); ++i) {
    const YamlNode entry = transforms[i];
    const auto child = reader.Name(entry["child_frame_id"]);
    if (!child.ok()) return child.status();
    const auto transform = reader.Transform(entry["transform"]);
    if (!transform.ok()) return transform.status();
    const std::size_t slash = (*child)[0] == '/' ? 1 : 0;
    frames.frames_.emplace(child->substr(slash), *transform);
  }
  return frames;
}

absl::StatusOr<ScenePose> SceneFrames::Find(const FieldReader& reader,
                                            const YamlNode& header) const {
  const YamlNode id = header["frame_id"];
  std::string name = id.is_scalar() ? id.yaml.Scalar() : "";
  if (!name.empty() && name[0] == '/') name.erase(0, 1);
  const auto found = frames_.find(name);
  if (found != frames_.end()) return found->second;
  return reader.Error(id, "must be the world's frame or one of fixed_frame_transforms");
}

absl::StatusOr<SceneFile> ParseYamlScene(std::string_view yaml, const std::string& file,
                                         const SceneOptions& options) {
  try {  // yaml-cpp reports errors by exceptions, which are handled here
    const YAML::Node root = YAML::Load(std::string(yaml));
    return ReadScene(YamlNode{root, "scene"}, FieldReader(file, yaml.size()), options);
  } catch (const YAML::Exception& error) {
    return FileError(file, {"YAML", "", error.what()});
  }
}

absl::StatusOr<SceneFile> ParseScene(std::string_view bytes, const std::string& file,
                                     const SceneOptions& options) {
  return IsTextScene(bytes) ? ParseTextScene(bytes, file) : ParseYamlScene(bytes, file, options);
}

}  // namespace cwm::formats
