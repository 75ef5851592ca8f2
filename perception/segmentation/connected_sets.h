// Sets of nodes that are connected on the measured surface.
#pragma once

#include <cstdint>
#include <vector>

#include "perception/cloud/no_index.h"
#include "perception/segmentation/surface_graph.h"

namespace cwm::perception {

struct ConnectedSets {
  std::vector<std::int32_t> of_node;       // per node its set; kNoIndex if it is in none
  std::vector<std::uint32_t> first_nodes;  // per set; ascending
  std::size_t count() const { return first_nodes.size(); }
};

// Returns the sets of nodes of the same class that are linked, directly or by way of nodes of that
// class. Nodes of a negative class are in no set. Sets are numbered in the order of their first
// nodes.
ConnectedSets FindConnectedSets(const SurfaceGraph& graph, const std::vector<std::int32_t>& classes,
                                const Work& work);

}  // namespace cwm::perception
