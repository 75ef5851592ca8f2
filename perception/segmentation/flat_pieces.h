// What is part of a support although nothing ties it to the support's surface.
#pragma once

#include <vector>

#include "perception/cloud/work.h"
#include "perception/segmentation/pieces.h"
#include "perception/segmentation/sight_map.h"
#include "perception/segmentation/support_planes.h"
#include "perception/segmentation/surface_graph.h"

namespace cwm::perception {

// Pieces that are linked to a support and nowhere rise above (or sink below) what noise and warp of
// the sensor can make of it become part of it; so do pieces, and nodes in no piece, that are not
// linked but lie on its plane beside it, as the last pixels of a far floor do, and pieces that lie
// there with nothing but hidden places between, as what is seen of a table between two things does.
// Without `sight` where not all was seen from one place. The numbers of the other pieces close up.
void AbsorbFlatPieces(const SurfaceGraph& graph, const CoarseCloud& coarse,
                      const std::vector<SupportPlane>& supports, const SightMap* sight,
                      Pieces& pieces, const Work& work);

}  // namespace cwm::perception
