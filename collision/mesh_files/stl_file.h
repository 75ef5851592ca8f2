// STL files, binary and text.
#pragma once

#include <string_view>

#include "absl/status/statusor.h"
#include "collision/geometry/triangle_mesh.h"
#include "collision/mesh_files/mesh_file_limits.h"

namespace cwm::collision {

// Same as ReadMeshFile. A file is binary if its length is that of a binary file with the number of
// triangles in its header, even if it begins like text. Otherwise it must begin with "solid" and is
// read as text. All solids of a text file are read as one mesh. Normals are ignored: the order of
// the corners defines the outside.
absl::StatusOr<TriangleMesh> ReadStl(std::string_view bytes, const MeshFileLimits& limits);

}  // namespace cwm::collision
