// Parts of a support that are not connected to the support's main surface.
#pragma once

#include <vector>

#include "perception/cloud/work.h"
#include "perception/segmentation/pieces.h"
#include "perception/segmentation/sight_map.h"
#include "perception/segmentation/support_planes.h"
#include "perception/segmentation/surface_graph.h"

namespace cwm::perception {

// Makes pieces part of a support if they are linked to it and nowhere rise above it (or sink below
// it) by more than the sensor's noise and warp explain. Pieces and unassigned nodes that are not
// linked become part of it too if they lie on its plane beside it, like the last pixels of a far
// floor. So do pieces on its plane with only hidden places between, like the part of a table that
// is visible between two objects. `sight` is null if not all points were seen from one place. The
// other pieces are renumbered without gaps.
void AbsorbFlatPieces(const SurfaceGraph& graph, const CoarseCloud& coarse,
                      const std::vector<SupportPlane>& supports, const SightMap* sight,
                      Pieces& pieces, const Work& work);

}  // namespace cwm::perception
