// The size of the tree that a scene graph unfolds to.
#pragma once

#include <cstdint>
#include <vector>

#include "absl/status/status.h"

namespace cwm::collision {

// chosen: far more nodes than any part of a robot has, far fewer than would exhaust memory.
inline constexpr std::int64_t kMaxSceneNodes = 100'000;

// Checks a graph of nodes, in which children[i] are the nodes below node i and may be shared.
// Refuses cycles, paths of more than 100 nodes, and graphs that unfold to more than 100 000 nodes;
// the parts of a robot have a few.
absl::Status CheckSceneGraph(const std::vector<std::vector<int>>& children);

}  // namespace cwm::collision
