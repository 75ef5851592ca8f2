// How much of a robot's files is read before they are refused. The defaults bound the memory and
// the time that a hostile file can take; a caller who knows its files may widen them.
#pragma once

#include <cstddef>

#include "collision/mesh_files/mesh_file_limits.h"

namespace cwm::collision {

struct RobotLimits {
  // A URDF or SRDF. The PR2's is 0.3 MB; a document takes up to forty times its size while read.
  std::size_t max_xml_bytes = std::size_t{8} << 20;
  int max_links = 1'024;   // their self pairs are half a million; humanoids with hands have 150
  int max_groups = 256;    // of an SRDF; PR2 has nine
  int max_states = 4'096;  // of an SRDF, of all groups together
  MeshFileLimits mesh_file = {};           // of one mesh
  std::size_t max_triangles = 10'000'000;  // of all meshes of a robot together
  // By the estimate of prepared_budget.h. A link with shapes takes some 60 kB, a mesh seven times its
  // binary STL.
  std::size_t max_free_prepared_bytes = std::size_t{4} << 20;
  std::size_t max_prepared_per_byte = 100;  // of the URDF and the meshes that it names
};

}  // namespace cwm::collision
