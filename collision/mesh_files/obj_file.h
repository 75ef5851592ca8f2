// Wavefront OBJ files.
#pragma once

#include <string_view>

#include "absl/status/statusor.h"
#include "collision/geometry/triangle_mesh.h"
#include "collision/mesh_files/mesh_file_limits.h"

namespace cwm::collision {

// Same as ReadMeshFile, for the vertices and faces of all objects and groups as one mesh.
// Everything else is ignored.
absl::StatusOr<TriangleMesh> ReadObj(std::string_view bytes, const MeshFileLimits& limits);

}  // namespace cwm::collision
