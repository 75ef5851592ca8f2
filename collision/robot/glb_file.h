// GLB files (glTF 2.0 in one file), by assimp.
#pragma once

#include <string_view>

#include "absl/status/statusor.h"
#include "collision/geometry/triangle_mesh.h"
#include "collision/robot/robot_limits.h"

namespace cwm::collision {

// As ReadMeshFile, of files that glb_guard.h lets through.
absl::StatusOr<TriangleMesh> ReadGlb(std::string_view bytes, const RobotLimits& limits);

}  // namespace cwm::collision
