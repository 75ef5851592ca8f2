// Mesh files that hold a scene of nodes: Collada and GLB, by assimp.
#pragma once

#include <string_view>

#include "absl/status/statusor.h"
#include "collision/geometry/triangle_mesh.h"
#include "collision/robot/robot_limits.h"

namespace cwm::collision {

// As ReadMeshFile. STL and OBJ are not left to assimp 5.2: a few changed bytes of an OBJ make it
// read where nothing is. These two it reads only after mesh_guard.h has looked at them.
absl::StatusOr<TriangleMesh> ReadCollada(std::string_view bytes, const RobotLimits& limits);
absl::StatusOr<TriangleMesh> ReadGlb(std::string_view bytes, const RobotLimits& limits);

}  // namespace cwm::collision
