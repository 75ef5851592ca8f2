// Triangle meshes of the usual formats.
#pragma once

#include <string>

#include "absl/status/statusor.h"
#include "collision/geometry/triangle_mesh.h"

namespace cwm::simulator {

// PLY, STL or OBJ, told by the ending of the path; coordinates are metres. Vertices at the same
// place become one, so that a closed STL is watertight. INVALID_ARGUMENT naming the file for other
// endings, for files that are missing or broken, and for those without a triangle.
absl::StatusOr<TriangleMesh> ReadMesh(const std::string& path);

}  // namespace cwm::simulator
