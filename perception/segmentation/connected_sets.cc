#include "perception/segmentation/connected_sets.h"

#include <algorithm>
#include <chrono>
#include <numeric>
#include <utility>

#include "perception/cloud/parallel_for.h"

namespace cwm::perception {
namespace {

using namespace std::chrono_literals;

constexpr std::size_t kNodesPerRange = ItemsPerChunk(20ns);

using Link = std::pair<std::uint32_t, std::uint32_t>;

// Union-find with the smallest node of a set as its root, so that the result does not depend on the
// order of joining and thus on the number of threads.
class Forest {
 public:
  explicit Forest(std::size_t count) : parent_(count) {
    std::iota(parent_.begin(), parent_.end(), 0u);
  }
  void Join(std::uint32_t a, std::uint32_t b) {
    if (parent_[a] == parent_[b]) return;  // most links join a set that is already one
    a = Root(a);
    b = Root(b);
    parent_[std::max(a, b)] = std::min(a, b);
  }
  std::uint32_t parent(std::uint32_t node) const { return parent_[node]; }

 private:
  std::uint32_t Root(std::uint32_t node) {
    while (parent_[node] != node) node = parent_[node] = parent_[parent_[node]];
    return node;
  }

  std::vector<std::uint32_t> parent_;
};

// Joins linked nodes within consecutive ranges of nodes, in parallel: each range touches its own
// part of the forest only. Returns the links between ranges.
std::vector<std::vector<Link>> JoinWithinRanges(const SurfaceGraph& graph,
                                                const std::vector<std::int32_t>& classes,
                                                Forest& forest, const Work& work) {
  std::vector<std::vector<Link>> between(graph.size() / kNodesPerRange + 1);
  ParallelFor(graph.size(), kNodesPerRange, work, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      if (classes[i] < 0) continue;
      const auto node = static_cast<std::uint32_t>(i);
      graph.ForEachLinkedBefore(i, [&](std::size_t j) {
        if (classes[j] != classes[i]) return;
        const auto other = static_cast<std::uint32_t>(j);
        if (j < begin) {
          between[begin / kNodesPerRange].emplace_back(node, other);
        } else {
          forest.Join(node, other);
        }
      });
    }
  });
  return between;
}

}  // namespace

ConnectedSets FindConnectedSets(const SurfaceGraph& graph, const std::vector<std::int32_t>& classes,
                                const Work& work) {
  Forest forest(graph.size());
  for (const std::vector<Link>& links : JoinWithinRanges(graph, classes, forest, work)) {
    for (const auto& [a, b] : links) forest.Join(a, b);
  }
  ConnectedSets sets;
  sets.of_node.assign(graph.size(), kNoIndex);
  for (std::uint32_t i = 0; i < graph.size(); ++i) {
    if (classes[i] < 0) continue;
    const std::uint32_t parent = forest.parent(i);
    if (parent == i) {
      sets.of_node[i] = static_cast<std::int32_t>(sets.count());
      sets.first_nodes.push_back(i);
    } else {
      sets.of_node[i] = sets.of_node[parent];  // the parent has its number already
    }
  }
  return sets;
}

}  // namespace cwm::perception
