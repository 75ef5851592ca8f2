// Where pieces of the measured surface start.
#pragma once

#include <cstdint>
#include <vector>

#include "perception/cloud/work.h"
#include "perception/segmentation/connected_sets.h"
#include "perception/segmentation/surface_graph.h"

namespace cwm::perception {

// measured: nodes that start a piece; with four fewer, noise at the edges of books starts some.
inline constexpr std::uint32_t kMinSeed_nodes = 40;

// Nodes that hang together, enough of them to start a piece with (kMinSeed_nodes).
struct Seeds {
  std::vector<std::int32_t> of_node;  // per node its seed, or kNoIndex
  std::vector<std::int32_t> classes;  // per seed the class of its nodes
  std::size_t count() const { return classes.size(); }
};

// Of each class of nodes (per node; negative: of no seed) what hangs together. A step of few sigma
// has gaps of one to three pixels, by which what lies before it and behind it hang together: where
// leaving out the neighbours of nodes at a step makes several of one, these are seeds of their own,
// unless they share a good part of their outlines, or a third as much with hardly a step along it.
// `crease` as of CutIntoPieces.
Seeds FindSeeds(const SurfaceGraph& graph, const std::vector<char>& crease,
                const std::vector<std::int32_t>& classes, const Work& work);

}  // namespace cwm::perception
