// GLB files (glTF 2.0 in one file), by assimp.
#pragma once

#include <string_view>

#include "absl/status/statusor.h"
#include "collision/geometry/triangle_mesh.h"
#include "collision/mesh_files/mesh_file_limits.h"

namespace cwm::collision {

// As ReadMeshFile, of files that glb_guard.h lets through.
absl::StatusOr<TriangleMesh> ReadGlb(std::string_view bytes, const MeshFileLimits& limits);

}  // namespace cwm::collision
