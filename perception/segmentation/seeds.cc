#include "perception/segmentation/seeds.h"

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <map>
#include <utility>

#include "perception/cloud/parallel_for.h"
#include "perception/cloud/tolerances.h"
#include "perception/segmentation/disjoint_sets.h"
#include "perception/segmentation/pieces.h"

namespace cwm::perception {
namespace {

using namespace std::chrono_literals;

// chosen: a step of few sigma has five times as many steps as links along it; where noise separated
// a surface there are at most a third as many steps as links.
constexpr int kMinLinksPerStep = 3;
// chosen: the factor by which a narrow contact is shorter than others: a handle is a few pixels
// wide.
constexpr int kNarrowContact = 3;

// Per set, whether it has enough points to be a seed.
std::vector<char> AreSeeds(const SurfaceGraph& graph, const ConnectedSets& sets) {
  std::vector<std::uint64_t> points(sets.count(), 0);
  for (std::size_t i = 0; i < graph.size(); ++i) {
    if (sets.of_node[i] >= 0) points[static_cast<std::size_t>(sets.of_node[i])] += graph.weight(i);
  }
  std::vector<char> are_seeds;
  for (std::uint64_t n : points) are_seeds.push_back(n >= kMinSeed_nodes);
  return are_seeds;
}

// The connected sets of nodes that have no node at a step beside them. No sets for a grid, whose
// nodes have no steps.
ConnectedSets SetsBesideNoStep(const SurfaceGraph& graph, const std::vector<std::int32_t>& classes,
                               const Work& work) {
  if (graph.image() == nullptr) {
    return {.of_node = std::vector<std::int32_t>(graph.size(), kNoIndex), .first_nodes = {}};
  }
  std::vector<std::int32_t> beside_none = classes;
  ParallelFor(graph.size(), ItemsPerChunk(20ns), work, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      if (classes[i] < 0) continue;
      graph.ForEachLinked(i, [&](std::size_t j) {
        if (graph.IsAtStep(j)) beside_none[i] = kNoIndex;
      });
    }
  });
  return FindConnectedSets(graph, beside_none, work);
}

// The border of two parts of one connected set, across the nodes that were left out.
struct Border {
  int links = 0;
  int steps = 0;  // pairs of pixels with a step between them
};

// The sets of nodes beside no step, as parts of the connected sets ("wholes") of all nodes.
class Parts {
 public:
  Parts(const SurfaceGraph& graph, const std::vector<char>& crease, const ConnectedSets& wholes,
        const ConnectedSets& parts)
      : graph_(graph),
        crease_(crease),
        wholes_(wholes),
        parts_(parts),
        is_seed_(AreSeeds(graph, parts)),
        seeds_of_whole_(wholes.count(), 0),
        groups_(parts.count()) {
    for (std::size_t p = 0; p < parts.count(); ++p) seeds_of_whole_[WholeOf(p)] += is_seed_[p];
    const auto is_split = [](int seeds) { return seeds > 1; };
    if (std::any_of(seeds_of_whole_.begin(), seeds_of_whole_.end(), is_split)) Rejoin();
  }

  // For a part that is a seed of a whole that falls apart: the first of the parts that it forms one
  // seed with. Else kNoIndex.
  std::int32_t GroupOf(std::size_t part) {
    if (!is_seed_[part] || seeds_of_whole_[WholeOf(part)] < 2) return kNoIndex;
    return static_cast<std::int32_t>(groups_.Root(part));
  }
  bool FallsApart(std::size_t whole) const { return seeds_of_whole_[whole] > 1; }

 private:
  std::size_t WholeOf(std::size_t part) const {
    return static_cast<std::size_t>(wholes_.of_node[parts_.first_nodes[part]]);
  }

  // Grows each part over the nodes that are nearest to it by links, including nodes at steps.
  void Grow() {
    grown_.assign(graph_.size(), kNoIndex);
    nodes_.assign(parts_.count(), 0);
    std::vector<std::uint32_t> front;
    for (std::uint32_t i = 0; i < graph_.size(); ++i) {
      if (parts_.of_node[i] < 0) continue;
      const auto part = static_cast<std::size_t>(parts_.of_node[i]);
      if (!is_seed_[part] || !FallsApart(WholeOf(part))) continue;
      grown_[i] = parts_.of_node[i];
      front.push_back(i);
    }
    for (std::size_t k = 0; k < front.size(); ++k) {
      const std::int32_t part = grown_[front[k]];
      ++nodes_[static_cast<std::size_t>(part)];
      graph_.ForEachLinked(front[k], [&](std::size_t j) {
        if (grown_[j] >= 0 || (wholes_.of_node[j] < 0 && (crease_[j] || !graph_.IsAtStep(j))))
          return;
        grown_[j] = part;
        front.push_back(static_cast<std::uint32_t>(j));
      });
    }
  }

  // Joins parts that share a good part of their outlines. Parts of narrow objects are also joined
  // if hardly any steps run along their common border, as noise makes steps too.
  void Rejoin() {
    Grow();
    std::map<std::pair<std::size_t, std::size_t>, Border> borders;
    const auto border = [&](std::size_t i, std::size_t j) -> Border* {
      if (j > i || grown_[j] < 0 || grown_[j] == grown_[i] || crease_[j]) return nullptr;
      const auto a = static_cast<std::size_t>(grown_[i]), b = static_cast<std::size_t>(grown_[j]);
      if (WholeOf(a) != WholeOf(b)) return nullptr;
      return &borders[std::minmax(a, b)];
    };
    for (std::size_t i = 0; i < graph_.size(); ++i) {
      if (grown_[i] < 0 || crease_[i]) continue;
      graph_.ForEachLinked(i, [&](std::size_t j) {
        if (Border* const b = border(i, j)) ++b->links;
      });
      graph_.ForEachAcrossStep(i, [&](std::size_t j) {
        if (Border* const b = border(i, j)) ++b->steps;
      });
    }
    for (const auto& [pair, border] : borders) {
      const auto& [a, b] = pair;
      const std::size_t smaller = std::min(nodes_[a], nodes_[b]);
      const bool is_split_by_noise = border.links >= kMinLinksPerStep * border.steps &&
                                     IsContact(kNarrowContact * border.links, smaller);
      if (!is_split_by_noise && !IsContact(border.links, smaller)) continue;
      if (groups_.Root(a) == groups_.Root(b)) continue;
      groups_.Join(a, b);
      --seeds_of_whole_[WholeOf(a)];
    }
  }

  const SurfaceGraph& graph_;
  const std::vector<char>& crease_;
  const ConnectedSets& wholes_;
  const ConnectedSets& parts_;
  std::vector<char> is_seed_;
  std::vector<int> seeds_of_whole_;
  DisjointSets groups_;              // of parts
  std::vector<std::int32_t> grown_;  // per node the part that it was given to
  std::vector<std::size_t> nodes_;   // per part, the number of its nodes
};

}  // namespace

Seeds FindSeeds(const SurfaceGraph& graph, const std::vector<char>& crease,
                const std::vector<std::int32_t>& classes, const Work& work) {
  const ConnectedSets wholes = FindConnectedSets(graph, classes, work);
  const ConnectedSets sets = SetsBesideNoStep(graph, classes, work);
  Parts parts(graph, crease, wholes, sets);
  const std::vector<char> is_seed = AreSeeds(graph, wholes);

  Seeds seeds;
  const auto add = [&](std::uint32_t first_node) {
    seeds.classes.push_back(classes[first_node]);
    return static_cast<std::int32_t>(seeds.count()) - 1;
  };
  std::vector<std::int32_t> of_whole(wholes.count(), kNoIndex);
  for (std::size_t w = 0; w < wholes.count(); ++w) {
    if (is_seed[w] && !parts.FallsApart(w)) of_whole[w] = add(wholes.first_nodes[w]);
  }
  std::vector<std::int32_t> of_set(sets.count(), kNoIndex);
  std::map<std::int32_t, std::int32_t> of_group;
  for (std::size_t s = 0; s < sets.count(); ++s) {
    const std::int32_t group = parts.GroupOf(s);
    if (group == kNoIndex) continue;
    const auto [seed, is_new] = of_group.try_emplace(group);
    if (is_new) seed->second = add(sets.first_nodes[s]);
    of_set[s] = seed->second;
  }
  seeds.of_node.assign(graph.size(), kNoIndex);
  ParallelFor(graph.size(), ItemsPerChunk(20ns), work, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      if (wholes.of_node[i] < 0) continue;
      seeds.of_node[i] = of_whole[static_cast<std::size_t>(wholes.of_node[i])];
      if (sets.of_node[i] < 0 || seeds.of_node[i] >= 0) continue;
      seeds.of_node[i] = of_set[static_cast<std::size_t>(sets.of_node[i])];
    }
  });
  return seeds;
}

}  // namespace cwm::perception
