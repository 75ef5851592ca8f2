// Where a surface turns towards the viewer: the borders between things that touch.
#pragma once

#include <vector>

#include "perception/segmentation/surface_graph.h"

namespace cwm::perception {

// Per node: 1 where the surface turns towards the viewer by more than `angle_rad` (positive, less
// than a right angle) between the two of one of its opposite pairs.
std::vector<char> ConcaveCreases(const SurfaceGraph& graph, float angle_rad, const Work& work);

// The same, pair by pair: what is done for graphs of cells, and what the loop over pixels is
// compared with.
std::vector<char> ConcaveCreasesByPairs(const SurfaceGraph& graph, float angle_rad,
                                        const Work& work);

}  // namespace cwm::perception
