// The first cut: every node of the measured surface goes to a support or to a piece that no concave
// crease and no depth jump runs through.
#pragma once

#include <cstdint>
#include <map>
#include <numbers>
#include <vector>

#include "perception/cloud/no_index.h"
#include "perception/segmentation/sight_map.h"
#include "perception/segmentation/support_planes.h"
#include "perception/segmentation/surface_graph.h"

namespace cwm::perception {

struct Pieces {
  // Per node: 0 .. support_count - 1 a support, support_count .. piece_count - 1 a piece of
  // something else, or kNoIndex where too little hangs together to be anything.
  std::vector<std::int32_t> of_node;
  std::int32_t support_count = 0;
  std::int32_t piece_count = 0;  // supports included
  // Pieces that lie on a support's plane and are separated from its larger part: the support. They
  // belong to it unless a vessel claims them for its floor.
  std::map<std::int32_t, std::int32_t> patch_of;
};

// Nodes of pieces that are no supports and are linked to another piece, a support among them;
// ascending.
std::vector<std::uint32_t> BorderNodes(const SurfaceGraph& graph, const Pieces& pieces,
                                       const Work& work);

// Whether that many links between two pieces, the smaller of so many nodes, are a good part of its
// outline; fewer are a touch in passing.
bool IsContact(int links, std::size_t nodes);

// chosen: above what warp bends a face by, below a box's edge.
inline constexpr float kConcave_rad = 20 * std::numbers::pi_v<float> / 180;

// `crease` is ConcaveCreases of the graph by kConcave_rad. Without `sight` where not all was seen
// from one place.
Pieces CutIntoPieces(const SurfaceGraph& graph, const std::vector<char>& crease,
                     const CoarseCloud& coarse, const std::vector<SupportPlane>& supports,
                     const SightMap* sight, const Work& work);

}  // namespace cwm::perception
