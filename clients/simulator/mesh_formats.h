// The two mesh formats that clients/formats does not read: STL and Wavefront OBJ. Strict: what does
// not fit is INVALID_ARGUMENT "FILE:LINE: FIELD is VALUE, RULE".
#pragma once

#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "clients/formats/mesh_file.h"

namespace cwm::simulator {

// Binary STL where the size is that of the triangles that it announces, else as text. Every
// triangle has vertices of its own; normals and attributes are not kept.
absl::StatusOr<formats::MeshFile> ParseStl(std::string_view bytes, const std::string& file);

// The v and f lines, polygons split into fans, indices counted from the start or, negative, from
// the end. Texture and normal coordinates, groups, materials, points and lines are left out;
// anything else is an error.
absl::StatusOr<formats::MeshFile> ParseObj(std::string_view bytes, const std::string& file);

}  // namespace cwm::simulator
