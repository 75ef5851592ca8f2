// What is asked of a mesh file before the library that reads it sees it. assimp recurses over the
// nodes of a scene, copies a shared node each time that it is used, and trusts the offsets in a
// GLB; a small file can make it overflow its stack, fill the memory or read past its end. (STL and
// OBJ have readers of their own.)
#pragma once

#include <string_view>

#include "absl/status/status.h"
#include "collision/robot/robot_limits.h"

namespace cwm::collision {

// XML without a DOCTYPE; lists of numbers hold numbers, counts fit the file. Nodes and instances of
// nodes make a tree that is neither deep nor large.
absl::Status GuardCollada(std::string_view bytes, const RobotLimits& limits);

// The same of glTF 2.0 nodes; accessors and views lie inside the file's own binary chunk.
absl::Status GuardGlb(std::string_view bytes, const RobotLimits& limits);

}  // namespace cwm::collision
