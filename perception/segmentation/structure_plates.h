// What walls and fronts fill: plates, as supports have, on each of their faces.
#pragma once

#include <vector>

#include "perception/segmentation/regions.h"
#include "perception/segmentation/support_polygon.h"

namespace cwm::perception {

// Bounded as supports are: by what was seen on the structure's plane, less the doorways and windows
// that rays pass through. Then the same of other faces among what lies off that plane, as a
// cabinet's own beside the doors that stand out from it, while each has the larger part of what is
// left. `segment` has a plane. Without `sight` where not all was seen from one place.
std::vector<Placed<Plate>> PlatesOfStructure(const Segment& segment, const CoarseCloud& coarse,
                                             const OrientedPoints& nodes, const SightMap* sight);

}  // namespace cwm::perception
