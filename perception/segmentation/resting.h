// Finds what each object rests on: a support, or another object on the support.
#pragma once

#include <cstdint>
#include <vector>

#include "collision/geometry/shape.h"
#include "perception/cloud/oriented_points.h"
#include "perception/cloud/work.h"
#include "perception/segmentation/regions.h"
#include "perception/segmentation/sight_map.h"

namespace cwm::perception {

// Without `sight` (null), a hidden gap below a hanging object does not count as contact.
// FormRegions always passes the sight map, also if not all points were seen from one place.

// Sets rests_on and foot_height_m of objects (segments with a support; plates are those of the
// supports). An object rests on another of the same support if
//   - its foot, the lowest fiftieth of its nodes, is above the support by more than
//     MaxJump_m, and above the other's foot as well, so that no two carry each other;
//   - the other's top is at its foot: beside at least 30 % of the nodes of its lowest tenth, within
//     2 cm horizontally and MaxJump_m in height, or as the upper end of what lies below it; a
//     hanging object may also hide how far the other reaches up to it;
//   - one is over the other: half of its footprint lies inside the other's, or half of the other's
//     top inside its own. An object that only leans on the other, or stands behind it, is beside
//     it. A hanging object (below) lies over the other with any share: nothing floats.
// If there are several, it rests on the one that it covers most. An object whose foot is hidden by
// something before it rests on the support.
void AssignResting(const OrientedPoints& nodes, const std::vector<Placed<Plate>>& plates,
                   const SightMap* sight, std::vector<Segment>& segments, const Work& work);

// Finds the objects under regions that no support carries because rays pass below their foot, such
// as a box across a lower one or a lid that overhangs. Sets `is_hanging` of all regions, and
// supported_by, the support at the bottom of the stack, of those that rest on an object or on
// another such region that does.
void AssignSupportsUnderStacks(const OrientedPoints& nodes,
                               const std::vector<Placed<Plate>>& plates, const SightMap* sight,
                               const std::vector<Segment>& objects, std::vector<Segment>& hanging,
                               const Work& work);

}  // namespace cwm::perception
