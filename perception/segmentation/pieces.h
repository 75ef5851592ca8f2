// The first stage of segmentation: every node of the measured surface goes to a support, or to a
// piece without a concave crease or a depth jump inside.
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
  // Per node: 0 .. support_count - 1 for a support, support_count .. piece_count - 1 for another
  // piece, or kNoIndex if too few nodes are connected to be anything.
  std::vector<std::int32_t> of_node;
  std::int32_t support_count = 0;
  std::int32_t piece_count = 0;  // supports included
  // The support of each piece that lies on that support's plane apart from its larger part. It
  // returns to the support unless a vessel claims it as its floor.
  std::map<std::int32_t, std::int32_t> patch_of;
};

// Nodes of pieces that are not supports and that are linked to another piece or a support, in
// ascending order.
std::vector<std::uint32_t> BorderNodes(const SurfaceGraph& graph, const Pieces& pieces,
                                       const Work& work);

// True if this number of links between two pieces, the smaller of which has `nodes` nodes, is a
// good part of its outline; fewer are an incidental touch.
bool IsContact(int links, std::size_t nodes);

// chosen: more than warp bends a face, less than a box's edge.
inline constexpr float kConcave_rad = 20 * std::numbers::pi_v<float> / 180;

// `crease` is FindConcaveCreases of the graph with kConcave_rad. `sight` is null if not all points
// were seen from one place.
Pieces CutIntoPieces(const SurfaceGraph& graph, const std::vector<char>& crease,
                     const CoarseCloud& coarse, const std::vector<SupportPlane>& supports,
                     const SightMap* sight, const Work& work);

}  // namespace cwm::perception
