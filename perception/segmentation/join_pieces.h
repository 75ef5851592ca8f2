// The second stage of segmentation: joins pieces that are parts of one solid, because cuts at every
// concave crease shatter vessels and handles, and occluders divide objects.
#pragma once

#include <cstdint>
#include <vector>

#include "perception/segmentation/pieces.h"
#include "perception/segmentation/sight_map.h"

namespace cwm::perception {

// Returns the same nodes with one piece per object. `sight` is null if the points were seen from
// several places: their rays do not tell hidden places from empty ones, so nothing is joined across
// occluders.
Pieces JoinPieces(const SurfaceGraph& graph, Pieces pieces, const SightMap* sight,
                  const Work& work = {});

}  // namespace cwm::perception
