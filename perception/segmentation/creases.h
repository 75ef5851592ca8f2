// Concave creases, where a surface turns towards the viewer: the borders between objects that
// touch.
#pragma once

#include <vector>

#include "perception/segmentation/surface_graph.h"

namespace cwm::perception {

// Per node: 1 if the surface turns towards the viewer by more than `angle_rad` (positive, less than
// a right angle) between the two nodes of one of its opposite pairs.
std::vector<char> FindConcaveCreases(const SurfaceGraph& graph, float angle_rad, const Work& work);

// The same, computed pair by pair: for graphs of cells, and as the reference for the vectorised
// loop over pixels.
std::vector<char> FindConcaveCreasesByPairs(const SurfaceGraph& graph, float angle_rad,
                                            const Work& work);

}  // namespace cwm::perception
