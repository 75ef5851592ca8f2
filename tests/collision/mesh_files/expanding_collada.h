// A Collada file of three kilobytes that unfolds to 2^15 tetrahedra or fewer.
#pragma once

#include <string>

#include "absl/strings/str_cat.h"
#include "tests/collision/mesh_files/mesh_bytes.h"

namespace cwm::collision::testing {

inline std::string ExpandingCollada(int doublings = 15) {
  const TriangleMesh tetrahedron{.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
                                 .triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}};
  std::string library;
  for (int i = 0; i < doublings; ++i) {  // the second instance is moved, so that no two coincide
    absl::StrAppend(&library, "<node id=\"n", i, "\"><instance_node url=\"#n", i + 1,
                    "\"/><node><translate>", 2 << i, " 0 0</translate><instance_node url=\"#n",
                    i + 1, "\"/></node></node>");
  }
  absl::StrAppend(&library, "<node id=\"n", doublings,
                  "\"><instance_geometry url=\"#part\"/></node>");
  return Collada(tetrahedron, {.scene_nodes = "<node><instance_node url=\"#n0\"/></node>",
                               .library_nodes = library});
}

}  // namespace cwm::collision::testing
