// The second stage of segmentation: joins pieces that are parts of one solid, because cuts at every
// concave crease shatter vessels and handles, and occluders divide objects.
#pragma once

#include <cstdint>
#include <vector>

#include "perception/segmentation/pieces.h"
#include "perception/segmentation/sight_map.h"

namespace cwm::perception {

// Returns the same nodes with one piece per object.
Pieces JoinPieces(const SurfaceGraph& graph, Pieces pieces, const SightMap& sight,
                  const Work& work = {});

}  // namespace cwm::perception
