// Triangle meshes of the usual formats, as users have them.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "collision/geometry/triangle_mesh.h"
#include "collision/mesh_files/up_axis.h"

namespace cwm::meshes {

using collision::UpAxis;

// Whether the bytes are to be read as a mesh: a PLY that has faces, a GLB, or what the ending of the
// file's name says is STL, OBJ or Collada.
bool IsMesh(std::string_view bytes, std::string_view file);

// PLY and GLB are told by their first bytes, STL, OBJ and Collada by the ending. As it stands in the
// file, in metres; vertices at the same place are one, so that a closed STL is watertight. A refusal
// names the file: other endings, what is broken, what has no triangle or too much of something.
absl::StatusOr<TriangleMesh> ParseMesh(std::string_view bytes, const std::string& file);

// The same with z up: `up` is the axis of the file that is, else what the file says
// (collision/mesh_files/mesh_file.h), z of a PLY.
absl::StatusOr<TriangleMesh> ParseUprightMesh(std::string_view bytes, const std::string& file,
                                              std::optional<UpAxis> up = {});

// The mesh of that path with z up as it says. Also refuses files that cannot be read.
absl::StatusOr<TriangleMesh> ReadMesh(const std::string& path);

}  // namespace cwm::meshes
