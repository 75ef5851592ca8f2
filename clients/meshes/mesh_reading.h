// Triangle meshes of the usual formats, as users have them.
#pragma once

#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "collision/geometry/triangle_mesh.h"
#include "collision/mesh_files/up_axis.h"

namespace cwm::meshes {

// Whether the bytes are to be read as a mesh: a PLY that has faces, a GLB, or what the ending of the
// file's name says is STL, OBJ or Collada.
bool IsMesh(std::string_view bytes, std::string_view file);

// PLY and GLB are told by their first bytes, STL, OBJ and Collada by the ending. As it stands in the
// file, in metres; vertices at the same place are one, so that a closed STL is watertight. A refusal
// names the file: other endings, what is broken, what has no triangle or too much of something.
absl::StatusOr<TriangleMesh> ParseMesh(std::string_view bytes, const std::string& file);

// Which axis of the file is up (collision/mesh_files/mesh_file.h); z of a PLY.
absl::StatusOr<collision::UpAxis> UpAxisOfMesh(std::string_view bytes, const std::string& file);

// The mesh of that path with z up. Also refuses files that cannot be read.
absl::StatusOr<TriangleMesh> ReadMesh(const std::string& path);

}  // namespace cwm::meshes
