// Joins pieces that only noise separates.
#pragma once

#include <vector>

#include "perception/cloud/work.h"
#include "perception/segmentation/pieces.h"
#include "perception/segmentation/plane_fit.h"
#include "perception/segmentation/seeds.h"
#include "perception/segmentation/surface_graph.h"

namespace cwm::perception {

// Joins pieces that share a good part of their outline without a crease or a step. A piece of which
// at least half is seen at a grazing angle, like the narrow side of a box, joins the piece that it
// shares most of its outline with. `pieces` have grown from `seeds`, in the same order; the classes
// of the seeds refer to `long_planes`, as LabelLongPlanes returns them. Remaining pieces are
// renumbered without gaps.
void JoinEvenPieces(const SurfaceGraph& graph, const std::vector<char>& crease, const Seeds& seeds,
                    const std::vector<Plane>& long_planes, Pieces& pieces, const Work& work);

}  // namespace cwm::perception
