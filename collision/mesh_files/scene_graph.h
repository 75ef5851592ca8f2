// How large the tree becomes that a graph of nodes unfolds to.
#pragma once

#include <cstdint>
#include <vector>

#include "absl/status/status.h"

namespace cwm::collision {

// Far above any part of a robot, far below what a thread's memory holds.
inline constexpr std::int64_t kMaxSceneNodes = 100'000;

// children[i] are the nodes below node i, which may be shared. Refuses cycles, paths of more than
// 100 nodes, and graphs that unfold to more than 100 000 nodes: the parts of a robot have a few.
absl::Status CheckSceneGraph(const std::vector<std::vector<int>>& children);

}  // namespace cwm::collision
