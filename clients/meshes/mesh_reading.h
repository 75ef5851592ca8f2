// Reads triangle meshes in the usual formats.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "collision/geometry/triangle_mesh.h"
#include "collision/mesh_files/up_axis.h"

namespace cwm::meshes {

using collision::UpAxis;

// True if the bytes are a mesh: a PLY with faces, a GLB, or by the ending of the file's name an
// STL, OBJ or Collada.
bool IsMesh(std::string_view bytes, std::string_view file);

// The mesh as it is in the file, in metres. PLY and GLB are recognised by their first bytes, STL,
// OBJ and Collada by the ending. Vertices at the same place are merged, so that a closed STL is
// watertight. Errors name the file: unknown endings, broken files, no triangles, exceeded limits.
absl::StatusOr<TriangleMesh> ParseMesh(std::string_view bytes, const std::string& file);

// The same with z up: `up` is the file's upward axis; by default as the file says
// (collision/mesh_files/mesh_file.h), and z for a PLY.
absl::StatusOr<TriangleMesh> ParseUprightMesh(std::string_view bytes, const std::string& file,
                                              std::optional<UpAxis> up = {});

// The mesh of a file with z up by default. Also refuses files that cannot be read.
absl::StatusOr<TriangleMesh> ReadMesh(const std::string& path);

}  // namespace cwm::meshes
