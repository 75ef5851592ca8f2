// Finds the seeds that pieces of the measured surface grow from.
#pragma once

#include <cstdint>
#include <vector>

#include "perception/cloud/work.h"
#include "perception/segmentation/connected_sets.h"
#include "perception/segmentation/surface_graph.h"

namespace cwm::perception {

// measured: the least number of points that start a piece; with four fewer, noise at the edges of
// books starts some.
inline constexpr std::uint32_t kMinSeed_nodes = 40;

// Connected sets of nodes with enough points to start a piece (kMinSeed_nodes).
struct Seeds {
  std::vector<std::int32_t> of_node;  // per node its seed, or kNoIndex
  std::vector<std::int32_t> classes;  // per seed the class of its nodes
  std::size_t count() const { return classes.size(); }
};

// Returns the connected sets of nodes of each class (per node; negative: in no seed). A step of few
// sigma has gaps of one to three pixels that connect the surfaces before and behind it. If a set
// falls apart without the neighbours of nodes at steps, its parts become separate seeds, unless
// they share a good part of their outlines, or a third as much with hardly any steps along it.
// `crease` is that of CutIntoPieces.
Seeds FindSeeds(const SurfaceGraph& graph, const std::vector<char>& crease,
                const std::vector<std::int32_t>& classes, const Work& work);

}  // namespace cwm::perception
