// PLY, the polygon file format, version 1.0: ascii, binary_little_endian, binary_big_endian.
#pragma once

#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "clients/formats/cloud_file.h"
#include "clients/formats/mesh_file.h"

namespace cwm::formats {

// The vertices with all their scalar properties as a cloud that is not organised; nx ny nz become
// normal_x normal_y normal_z. Strict like ParsePcd; lists in vertices are refused, other elements
// are skipped.
absl::StatusOr<CloudFile> ParsePlyCloud(std::string_view bytes, const std::string& file);

// The vertices and faces; polygons are split into fans. INVALID_ARGUMENT also when an index names
// no vertex, a coordinate is not finite, or there is no face.
absl::StatusOr<MeshFile> ParsePlyMesh(std::string_view bytes, const std::string& file);

// Whether the header announces faces: then it is a mesh, else a cloud. A header that is no such is
// for the readers to refuse.
bool HasPlyFaces(std::string_view bytes);

// binary_little_endian with coordinates as doubles: reading it back gives the same mesh.
std::string FormatPlyMesh(const MeshFile& mesh);

}  // namespace cwm::formats
