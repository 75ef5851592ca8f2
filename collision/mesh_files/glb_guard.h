// What is asked of a GLB file before the library that reads it sees it. assimp recurses over the
// nodes of a scene, copies a shared node each time that it is used, and trusts the offsets in the
// file; a small one can make it overflow its stack, fill the memory or read past the end.
#pragma once

#include <string_view>

#include "absl/status/status.h"
#include "collision/mesh_files/mesh_file_limits.h"

namespace cwm::collision {

// The nodes make a tree that is neither deep nor large; accessors and views lie inside the file's
// own binary chunk; primitives are triangles whose indices are vertices that there are.
absl::Status GuardGlb(std::string_view bytes, const MeshFileLimits& limits);

}  // namespace cwm::collision
