// Converts a planning scene to changes of a world.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "clients/cpp/connection.h"
#include "clients/formats/scene_file.h"
#include "cwm/v1/world.pb.h"

namespace cwm::scene {

// Parts of a scene besides its objects; all concern its robot.
enum class ScenePart { kState = 1, kAllowed, kAttached };

// The fate of previously imported objects.
enum class PreviousObjects { kKeep, kRemove };

// The progress of sending a scene's meshes to the server.
struct MeshUploadProgress {
  std::size_t mesh = 0;  // number of the mesh being sent, from 1
  std::size_t meshes = 0;
  std::int64_t sent_bytes = 0;  // of all meshes so far
  std::int64_t total_bytes = 0;
};

struct ImportOptions {
  // The world's robot to which the scene belongs; nullptr: the world has none, and these parts are
  // ignored with a warning.
  const cwm::v1::Robot* robot = nullptr;
  // The world's pair rules; what they allow ends if the scene says false for the pair.
  std::vector<cwm::v1::PairRule> rules = {};
  std::vector<ScenePart> excluded = {};
  // The world's objects put by users, which includes imported ones, and whether they stay besides
  // those of the scene. If they are removed, so are previous allowances that the scene does not
  // have.
  std::vector<std::string> objects = {};
  PreviousObjects previous = PreviousObjects::kKeep;
  std::function<void(const MeshUploadProgress&)> progress = {};  // called whenever bytes were sent

  bool Includes(ScenePart part) const;
};

// The imported parts of a scene, as text for people and as changes.
struct SceneImport {
  std::vector<cwm::v1::Change> changes;
  std::vector<std::string> imported;
  std::vector<std::string> warnings;  // including those of the scene
};

// True if the scene has any of the parts that are to be imported.
bool NeedsRobot(const formats::SceneFile& scene, const ImportOptions& options);

// Stores the meshes on the server. The caller applies the changes in this order, or uses them as an
// overlay of queries. INVALID_ARGUMENT if two objects would have the same name, and if previous
// objects are to be removed although the scene only has differences.
absl::StatusOr<SceneImport> ConvertScene(const client::Connection& connection,
                                         const formats::SceneFile& scene,
                                         const ImportOptions& options);

}  // namespace cwm::scene
