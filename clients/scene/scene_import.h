// A planning scene as changes of a world.
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

// Parts of a scene beside its objects: all of them are about its robot.
enum class Part { kState = 1, kAllowed, kAttached };

// What becomes of what was imported before.
enum class Before { kStays, kGoes };

// How far the meshes of a scene are on their way to the server.
struct MeshesSent {
  std::size_t mesh = 0;  // that is being sent, from 1
  std::size_t meshes = 0;
  std::int64_t sent_bytes = 0;  // of all meshes, those before included
  std::int64_t total_bytes = 0;
};

struct ImportOptions {
  // Of the world, whose scene it is; nullptr: the world has none, and the parts are left out with a
  // warning.
  const cwm::v1::Robot* robot = nullptr;
  // Of the world: what they allow ends where the scene says false to it.
  std::vector<cwm::v1::PairRule> rules = {};
  std::vector<Part> without = {};
  // Of the world: objects that users put, as imports do, and whether they stay beside those of the
  // scene. Where they go, so do pairs that were allowed before and that the scene does not allow.
  std::vector<std::string> objects = {};
  Before before = Before::kStays;
  std::function<void(const MeshesSent&)> progress = {};  // hears it whenever some are handed over

  bool Takes(Part part) const;
};

// What is taken of a scene, for people to read and the server to do.
struct SceneImport {
  std::vector<cwm::v1::Change> changes;
  std::vector<std::string> taken;
  std::vector<std::string> warnings;  // those of the scene included
};

// Whether the scene says anything of the parts that are taken.
bool NeedsRobot(const formats::SceneFile& scene, const ImportOptions& options);

// Meshes are stored with the server; the changes are for the caller to apply, in this order, or to
// lay over a question. INVALID_ARGUMENT where two objects would have one name, and where what was
// before is to go for a scene that only says what differs from it.
absl::StatusOr<SceneImport> ImportOf(const client::Connection& connection,
                                     const formats::SceneFile& scene, const ImportOptions& options);

}  // namespace cwm::scene
