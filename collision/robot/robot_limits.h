// Limits on the files of a robot, beyond which they are refused. The defaults bound the memory and
// the time that a hostile file can take; a caller that trusts its files may raise them.
#pragma once

#include <cstddef>

#include "collision/mesh_files/mesh_file_limits.h"

namespace cwm::collision {

struct RobotLimits {
  // chosen: for a URDF or SRDF. The PR2's URDF has 0.3 MB; a document takes up to forty times its
  // size while it is read.
  std::size_t max_xml_bytes = std::size_t{8} << 20;
  int max_links = 1'024;          // half a million self pairs; humanoids with hands have 150 links
  int max_groups = 256;           // of an SRDF; PR2 has nine
  int max_states = 4'096;         // of an SRDF, of all groups together
  MeshFileLimits mesh_file = {};  // of one mesh
  std::size_t max_triangles = 10'000'000;  // of all meshes of a robot together
  // Limits of prepared_budget.h. A link with shapes takes some 60 kB, a mesh seven times its binary
  // STL.
  std::size_t max_free_prepared_bytes = std::size_t{4} << 20;
  std::size_t max_prepared_per_byte = 100;  // of the URDF and its mesh files
};

}  // namespace cwm::collision
