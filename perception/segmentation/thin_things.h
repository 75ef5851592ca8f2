// Things on a support that are hardly higher than its noise and warp: phones, books, plates.
#pragma once

#include <vector>

#include "perception/cloud/work.h"
#include "perception/segmentation/pieces.h"
#include "perception/segmentation/support_planes.h"
#include "perception/segmentation/surface_graph.h"

namespace cwm::perception {

// Makes a piece of each patch of a support that rises like a thing instead of bending like the
// sensor's warp:
//   - its mean height above the support around it is significant (kSignificant_errors), warp
//     included;
//   - it ends in a step: along its outline the height changes over a finger's width by a good part
//     of that mean, significantly, and so it does on nearly all sides that show the support.
// Patches narrower than a finger are edges of other things. New pieces follow the others.
void SeparateThinThings(const SurfaceGraph& graph, const std::vector<SupportPlane>& supports,
                        Pieces& pieces, const Work& work);

}  // namespace cwm::perception
