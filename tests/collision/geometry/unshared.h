// Meshes as files without indices have them.
#pragma once

#include <cstdint>

#include "collision/geometry/triangle_mesh.h"

namespace cwm {

// The mesh with separate vertices for each triangle, as in an STL file.
inline TriangleMesh Unshared(const TriangleMesh& mesh) {
  TriangleMesh loose;
  for (const TriangleMesh::Triangle& t : mesh.triangles) {
    const auto first = static_cast<std::uint32_t>(loose.vertices.size());
    for (const std::uint32_t v : t) loose.vertices.push_back(mesh.vertices[v]);
    loose.triangles.push_back({first, first + 1, first + 2});
  }
  return loose;
}

}  // namespace cwm
