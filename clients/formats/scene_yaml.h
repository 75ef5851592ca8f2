// The parts of a planning scene in YAML. Each reader refuses what does not fit by its path.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "clients/formats/scene_file.h"
#include "clients/formats/yaml_place.h"

namespace cwm::formats {

// The frames that a file's poses may be in, each in the world.
class SceneFrames {
 public:
  // Those that `fixed_frame_transforms` gives, and the world's own.
  static absl::StatusOr<SceneFrames> Read(const FieldReader& reader, const Place& transforms,
                                          const std::string& world_frame);
  // Of the frame that the header beside a pose names, which need not be there.
  absl::StatusOr<ScenePose> Find(const FieldReader& reader, const Place& header) const;

 private:
  std::map<std::string, ScenePose> frames_;
};

enum class SceneKind { kWhole, kDiff };
enum class SceneOperation { kAdd, kRemove };

// What is to be done with an object; only differences may remove.
absl::StatusOr<SceneOperation> ReadOperation(const FieldReader& reader, const Place& place,
                                             SceneKind kind);

// An object in its own frame; where that is, is for the caller to say.
absl::StatusOr<SceneObject> ReadObject(const FieldReader& reader, const Place& place,
                                       std::vector<std::string>& warnings);

absl::StatusOr<SceneRobotState> ReadRobotState(const FieldReader& reader, const Place& place,
                                               const SceneFrames& frames,
                                               std::vector<std::string>& warnings);

absl::StatusOr<SceneAllowedCollisions> ReadAllowedCollisions(const FieldReader& reader,
                                                             const Place& place,
                                                             std::vector<std::string>& warnings);

absl::StatusOr<SceneFile> ParseYamlScene(std::string_view yaml, const std::string& file,
                                         const SceneOptions& options);
// The ".scene" format.
absl::StatusOr<SceneFile> ParseTextScene(std::string_view text, const std::string& file);

}  // namespace cwm::formats
