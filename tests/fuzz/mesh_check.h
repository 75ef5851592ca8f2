// The contract of every mesh that was read.
#pragma once

#include <string_view>

#include "collision/mesh_files/mesh_file.h"
#include "tests/fuzz/fuzz_target.h"

namespace cwm::fuzz {

inline void CheckMeshFile(std::string_view bytes, std::string_view name) {
  const auto mesh = collision::ReadMeshFile(bytes, name);
  if (!mesh.ok()) {
    Check(!mesh.status().message().empty(), "a refusal must have a message");
    return;
  }
  Check(!mesh->triangles.empty(), "a mesh must have triangles");
  Check(mesh->triangles.size() <= collision::MeshFileLimits{}.MaxTrianglesOf(bytes.size()),
        "a mesh must not have more triangles than its bytes allow");
  for (const auto& triangle : mesh->triangles) {
    for (const std::uint32_t v : triangle) Check(v < mesh->vertices.size(), "no such vertex");
  }
  for (const Vector3& p : mesh->vertices) Check(p.allFinite(), "vertices must be finite");
}

}  // namespace cwm::fuzz
