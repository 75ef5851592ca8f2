// Pieces that noise alone parted.
#pragma once

#include <vector>

#include "perception/cloud/work.h"
#include "perception/segmentation/pieces.h"
#include "perception/segmentation/plane_fit.h"
#include "perception/segmentation/seeds.h"
#include "perception/segmentation/surface_graph.h"

namespace cwm::perception {

// Pieces that share a good part of their outline without a crease or a step become one; what is
// seen at a grazing angle alone goes to the one that it shares most of it with, as the narrow side
// of a box does. `pieces` have grown from `seeds`, in their order; the classes of seeds are of
// `long_planes`, as ClassLongPlanes gives them. The numbers of the others close up.
void JoinEvenPieces(const SurfaceGraph& graph, const std::vector<char>& crease, const Seeds& seeds,
                    const std::vector<Plane>& long_planes, Pieces& pieces, const Work& work);

}  // namespace cwm::perception
