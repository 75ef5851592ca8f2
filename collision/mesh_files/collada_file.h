// Collada files (DAE 1.4 and 1.5).
#pragma once

#include <string_view>

#include "absl/status/statusor.h"
#include "collision/geometry/triangle_mesh.h"
#include "collision/mesh_files/mesh_file_limits.h"
#include "collision/mesh_files/up_axis.h"

namespace cwm::collision {

// As ReadMeshFile: the geometries that the nodes of the scene use, as triangles, polylists and
// polygons; lines are left out. Nodes may use nodes of the library, which are then there each time.
// What would put surfaces elsewhere if it were passed over is refused: strips and fans, skins,
// lookat and skew.
absl::StatusOr<TriangleMesh> ReadCollada(std::string_view bytes, const MeshFileLimits& limits);

// What <up_axis> says, Y where it says nothing.
absl::StatusOr<UpAxis> ColladaUpAxis(std::string_view bytes, const MeshFileLimits& limits);

}  // namespace cwm::collision
