// Collada files (DAE 1.4 and 1.5).
#pragma once

#include <string_view>

#include "absl/status/statusor.h"
#include "collision/geometry/triangle_mesh.h"
#include "collision/mesh_files/mesh_file_limits.h"
#include "collision/mesh_files/up_axis.h"

namespace cwm::collision {

// Same as ReadMeshFile, for the geometries that the nodes of the scene use: triangles, polylists
// and polygons; lines are left out. Nodes may instantiate library nodes, which are repeated each
// time. Elements that would move surfaces if they were ignored are refused: strips and fans, skins,
// lookat and skew.
absl::StatusOr<TriangleMesh> ReadCollada(std::string_view bytes, const MeshFileLimits& limits);

// The axis in <up_axis>, Y if there is none.
absl::StatusOr<UpAxis> ColladaUpAxis(std::string_view bytes, const MeshFileLimits& limits);

}  // namespace cwm::collision
