// Tells whether a mesh bounds a solid, in words.
#pragma once

#include <string>

#include "collision/geometry/triangle_mesh.h"

namespace cwm::meshes {

struct MeshSolid {
  bool is_open = false;  // a surface without an inside
  std::string text;      // "closed", "closed (an edge split at vertices on it)", "open"
};

// The server closes a mesh in the same way (collision/geometry/mesh_closing.h).
MeshSolid DescribeSolid(const TriangleMesh& mesh);

}  // namespace cwm::meshes
