// Reads the parts of a planning scene in YAML. Errors have the path of the field.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "clients/formats/scene_file.h"
#include "clients/formats/yaml_node.h"

namespace cwm::formats {

// The frames in which a file may give poses, relative to the world.
class SceneFrames {
 public:
  // The world's frames and those of `fixed_frame_transforms`.
  static absl::StatusOr<SceneFrames> Read(const FieldReader& reader, const YamlNode& transforms,
                                          const std::string& world_frame);
  // The pose of the frame in a header, which is optional.
  absl::StatusOr<ScenePose> Find(const FieldReader& reader, const YamlNode& header) const;

 private:
  std::map<std::string, ScenePose> frames_;
};

enum class SceneKind { kFull, kDiff };
enum class SceneOperation { kAdd, kRemove };

// The operation of an object; only differences may remove objects.
absl::StatusOr<SceneOperation> ReadOperation(const FieldReader& reader, const YamlNode& node,
                                             SceneKind kind);

// An object in its own frame; the caller sets the pose of that frame.
absl::StatusOr<SceneObject> ReadObject(const FieldReader& reader, const YamlNode& node,
                                       std::vector<std::string>& warnings);

absl::StatusOr<SceneRobotState> ReadRobotState(const FieldReader& reader, const YamlNode& node,
                                               const SceneFrames& frames,
                                               std::vector<std::string>& warnings);

absl::StatusOr<SceneAllowedCollisions> ReadAllowedCollisions(const FieldReader& reader,
                                                             const YamlNode& node,
                                                             std::vector<std::string>& warnings);

absl::StatusOr<SceneFile> ParseYamlScene(std::string_view yaml, const std::string& file,
                                         const SceneOptions& options);
// Reads the ".scene" format.
absl::StatusOr<SceneFile> ParseTextScene(std::string_view text, const std::string& file);

}  // namespace cwm::formats
