// PLY, the polygon file format, version 1.0: ascii, binary_little_endian, binary_big_endian.
#pragma once

#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "clients/formats/cloud_file.h"
#include "clients/formats/mesh_file.h"

namespace cwm::formats {

// The vertices with all their scalar properties as an unorganised cloud; nx ny nz become normal_x
// normal_y normal_z. Strict like ParsePcd; lists in vertices are refused, other elements are
// skipped.
absl::StatusOr<CloudFile> ParsePlyCloud(std::string_view bytes, const std::string& file);

// The vertices and faces; polygons are split into fans. INVALID_ARGUMENT also if an index is out of
// range, a coordinate is not finite, or there is no face.
absl::StatusOr<MeshFile> ParsePlyMesh(std::string_view bytes, const std::string& file);

// True if the header announces faces: then the file is a mesh, otherwise a cloud. Invalid headers
// are reported by the readers.
bool HasPlyFaces(std::string_view bytes);

// Writes binary_little_endian with double coordinates, so that reading it gives the same mesh.
std::string FormatPlyMesh(const MeshFile& mesh);

}  // namespace cwm::formats
