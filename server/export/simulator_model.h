// A world as a robot description or a simulator's world: URDF and SDFormat, with meshes in separate
// files.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "server/export/planning_scene.h"

namespace cwm::server {

struct NamedFile {
  std::string name;  // relative to the first file, whose name is empty
  std::string bytes;
};

struct ModelFiles {
  std::vector<NamedFile> files;       // the description first, then the meshes, as binary STL
  std::vector<std::string> warnings;  // what the format expresses differently, or not at all
};

// A robot that does not move: a link for each object, with its name, fixed to the root "world"
// (with underscores appended if an object has that name); each part is collision and visual. Cones
// become meshes, and a half-space becomes a box of 20 m by 20 m by 1 m below its plane.
// ResourceExhausted GEOMETRY_TOO_LARGE if all meshes then have more than `max_triangles` together.
absl::StatusOr<ModelFiles> FormatUrdf(PlanningScene scene, std::int64_t max_triangles,
                                      const CancellationCheck& check_cancelled = absl::OkStatus);

// SDFormat 1.7: a world of static models, one for each object, with its name. Cones become meshes,
// a half-space a plane. "_1" is appended to reserved names ("world", "__x__"). Errors as above.
absl::StatusOr<ModelFiles> FormatSdf(PlanningScene scene, std::int64_t max_triangles,
                                     const CancellationCheck& check_cancelled = absl::OkStatus);

}  // namespace cwm::server
