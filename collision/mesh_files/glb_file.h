// GLB files (glTF 2.0 in one file).
#pragma once

#include <string_view>

#include "absl/status/statusor.h"
#include "collision/geometry/triangle_mesh.h"
#include "collision/mesh_files/mesh_file_limits.h"

namespace cwm::collision {

// Same as ReadMeshFile, for the triangles, strips and fans of the meshes that the nodes of the
// scene use, each with the transforms of its nodes. Materials, textures, cameras, lights,
// animations and unused meshes are ignored. Features that would move surfaces if they were ignored
// are refused: points and lines, sparse accessors, morph targets, skins, and extensions that change
// geometry.
absl::StatusOr<TriangleMesh> ReadGlb(std::string_view bytes, const MeshFileLimits& limits);

}  // namespace cwm::collision
