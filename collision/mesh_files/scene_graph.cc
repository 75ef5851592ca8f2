#include "collision/mesh_files/scene_graph.h"

#include <algorithm>
#include <cstdint>
#include <optional>

namespace cwm::collision {
namespace {

// chosen: far deeper than any part of a robot, far below what a thread's stack holds.
constexpr int kMaxGraphDepth = 100;

class Unfolding {
 public:
  explicit Unfolding(const std::vector<std::vector<int>>& children)
      : children_(children), size_(children.size()) {}

  absl::Status Check() {
    for (std::size_t i = 0; i < children_.size(); ++i) {
      if (absl::Status status = Measure(static_cast<int>(i), 1); !status.ok()) return status;
    }
    std::vector<bool> has_parent(children_.size(), false);
    for (const auto& below : children_) {
      for (const int child : below) has_parent[child] = true;
    }
    std::int64_t nodes = 0;
    for (std::size_t i = 0; i < children_.size(); ++i) {
      if (!has_parent[i]) nodes = std::min(nodes + *size_[i], kMaxSceneNodes + 1);
    }
    return nodes <= kMaxSceneNodes
               ? absl::OkStatus()
               : absl::InvalidArgumentError("nodes must not unfold to more than 100000");
  }

 private:
  struct Measured {
    std::int64_t nodes = 1;
    int height = 1;
  };

  // Measures the tree below a node. The recursion is at most kMaxGraphDepth deep.
  absl::Status Measure(int node, int depth) {
    if (size_[node].has_value() && depth + height_[node] - 1 <= kMaxGraphDepth)
      return absl::OkStatus();
    if (depth > kMaxGraphDepth || size_[node].has_value()) {
      return absl::InvalidArgumentError("nodes must not nest deeper than 100, nor in a circle");
    }
    Measured measured;
    for (const int child : children_[node]) {
      if (absl::Status status = Measure(child, depth + 1); !status.ok()) return status;
      measured.nodes = std::min(measured.nodes + *size_[child], kMaxSceneNodes + 1);
      measured.height = std::max(measured.height, 1 + height_[child]);
    }
    size_[node] = measured.nodes;
    height_[node] = measured.height;
    return absl::OkStatus();
  }

  const std::vector<std::vector<int>>& children_;
  std::vector<std::optional<std::int64_t>> size_;
  std::vector<int> height_ = std::vector<int>(children_.size(), 0);
};

}  // namespace

absl::Status CheckSceneGraph(const std::vector<std::vector<int>>& children) {
  return Unfolding(children).Check();
}

}  // namespace cwm::collision
