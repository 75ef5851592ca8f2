// STL files, binary and text.
#pragma once

#include <string_view>

#include "absl/status/statusor.h"
#include "collision/geometry/triangle_mesh.h"
#include "collision/mesh_files/mesh_file_limits.h"

namespace cwm::collision {

// As ReadMeshFile. A file whose length is that of a binary one with as many triangles as it says is
// binary, even where its header begins like text; another one is text. All solids of a text are
// read as one mesh. Normals are not looked at: the order of the corners says what is outside.
absl::StatusOr<TriangleMesh> ReadStl(std::string_view bytes, const MeshFileLimits& limits);

}  // namespace cwm::collision
