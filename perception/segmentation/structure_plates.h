// The plates of walls and fronts, bounded like those of supports, on each of their faces.
#pragma once

#include <vector>

#include "perception/segmentation/regions.h"
#include "perception/segmentation/support_polygon.h"

namespace cwm::perception {

// Returns plates bounded by what was seen on the structure's plane, without doorways and windows
// that rays pass through. Then adds those of other faces off that plane, such as the cabinet behind
// doors that stand out from it, as long as each holds the larger part of what is left. `segment`
// has a plane. `sight` is null if not all points were seen from one place.
std::vector<Placed<Plate>> PlatesOfStructure(const Segment& segment, const CoarseCloud& coarse,
                                             const OrientedPoints& nodes, const SightMap* sight);

}  // namespace cwm::perception
