// The second stage of segmentation: pieces that are parts of one object are joined by what a solid
// explains, because cutting at every concave crease shatters vessels and handles, and occluders cut
// objects in two.
#pragma once

#include <cstdint>
#include <vector>

#include "perception/segmentation/pieces.h"
#include "perception/segmentation/sight_map.h"

namespace cwm::perception {

// The same nodes with pieces that are whole objects.
Pieces JoinPieces(const SurfaceGraph& graph, Pieces pieces, const SightMap& sight,
                  const Work& work = {});

}  // namespace cwm::perception
