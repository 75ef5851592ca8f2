// A world as robot descriptions and simulators have it: URDF and SDFormat, with meshes in files
// beside.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "server/export/planning_scene.h"

namespace cwm::server {

struct NamedFile {
  std::string name;  // relative to the first file, which is empty
  std::string bytes;
};

struct ModelFiles {
  std::vector<NamedFile> files;       // the description first, then the meshes, as binary STL
  std::vector<std::string> warnings;  // what the format says otherwise, or not at all
};

// A robot that does not move: a link for each object under its name, fixed to the root "world"
// (with underscores behind where an object is called so), each part as collision and visual. Cones
// become meshes, and a half-space the top of a box of 20 m by 20 m and 1 m. ResourceExhausted
// GEOMETRY_TOO_LARGE when all meshes have more than `max_triangles` together then.
absl::StatusOr<ModelFiles> FormatUrdf(PlanningScene scene, std::int64_t max_triangles,
                                      const GoOn& go_on = absl::OkStatus);

// SDFormat 1.7, a world of static models, one for each object under its name. Cones become meshes,
// a half-space is a plane. Names that the format keeps for itself ("world", "__x__") get "_1" behind. Errors as above.
absl::StatusOr<ModelFiles> FormatSdf(PlanningScene scene, std::int64_t max_triangles,
                                     const GoOn& go_on = absl::OkStatus);

}  // namespace cwm::server
