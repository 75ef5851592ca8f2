// Sets of nodes that hang together on the measured surface.
#pragma once

#include <cstdint>
#include <vector>

#include "perception/cloud/no_index.h"
#include "perception/segmentation/surface_graph.h"

namespace cwm::perception {

struct ConnectedSets {
  std::vector<std::int32_t> of_node;       // per node its set; kNoIndex where it is in none
  std::vector<std::uint32_t> first_nodes;  // per set; ascending
  std::size_t count() const { return first_nodes.size(); }
};

// Nodes of one class that are linked, directly or by way of others of their class, are one set;
// those of a negative class are in none. Numbered in the order of their first nodes.
ConnectedSets FindConnectedSets(const SurfaceGraph& graph, const std::vector<std::int32_t>& classes,
                                const Work& work);

}  // namespace cwm::perception
