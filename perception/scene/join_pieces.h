// The second stage of segmentation: pieces that are parts of one object are joined by what a solid
// explains, because cutting at every concave crease shatters vessels and handles, and occluders cut
// objects in two.
#pragma once

#include <cstdint>
#include <vector>

#include "perception/scene/pieces.h"
#include "perception/scene/sight_map.h"

namespace cwm::perception {

// Per piece the object that it belongs to: the smallest number among the object's pieces. Supports
// are objects of their own.
std::vector<std::int32_t> JoinPieces(const SurfaceGraph& graph, const Pieces& pieces,
                                     const SightMap& sight);

}  // namespace cwm::perception
