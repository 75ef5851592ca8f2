// Tells whether a mesh bounds a solid, in words.
#pragma once

#include <string>

#include "collision/geometry/mesh_closing.h"

namespace cwm::meshes {

struct MeshSolid {
  bool is_open = false;   // a surface without an inside
  bool has_caps = false;  // a solid whose holes were closed
  // "closed", "closed (an edge split at vertices on it)", "closed by caps of 2 holes, the largest
  // 9.0 mm", "open: a hole of 400.0 mm, 21 % of its area".
  std::string text;
};

// The server closes a mesh in the same way (collision/geometry/mesh_closing.h).
MeshSolid DescribeSolid(const TriangleMesh& mesh);

}  // namespace cwm::meshes
