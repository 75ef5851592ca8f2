// What rests on what: objects stand on a support, or on objects that stand there.
#pragma once

#include <cstdint>
#include <vector>

#include "collision/geometry/shape.h"
#include "perception/cloud/oriented_points.h"
#include "perception/cloud/work.h"
#include "perception/segmentation/regions.h"
#include "perception/segmentation/sight_map.h"

namespace cwm::perception {

// `sight` is null where not all was seen from one place, or nothing is known of it.

// Sets rests_on and foot_height_m of objects (segments with a support; plates are those of the
// supports). An object rests on another of the same support when
//   - its foot, the lowest fiftieth of its nodes, is above the support by more than
//     LargestJump_m, and above the other's foot as well, so that no two carry each other;
//   - the other's top is where the foot is: beside at least 30 % of the nodes of the lowest tenth,
//     within 2 cm across and LargestJump_m in height, or as the upper end of what lies below it;
//     what hangs may hide how far the other one reaches up to it;
//   - one is over the other: half of its footprint lies inside the other's, or half of the other's
//     top inside its own. What merely leans on the other, or stands behind it, is beside it. What
//     hangs (below) lies over the other with any share: nothing floats.
// Of several the one that it covers most. An object whose foot is hidden by what stands before it
// rests on the support.
void FindWhatTheyRestOn(const OrientedPoints& nodes, const std::vector<Placed<Plate>>& plates,
                        const SightMap* sight, std::vector<Segment>& segments, const Work& work);

// Sets supported_by, the support at the bottom of the stack, and `hangs` of regions that no support
// carries because one sees below their foot: where they rest on an object, or on another such
// region that does: a box across a lower one, a lid that overhangs.
void FindSupportsUnderStacks(const OrientedPoints& nodes, const std::vector<Placed<Plate>>& plates,
                             const SightMap* sight, const std::vector<Segment>& objects,
                             std::vector<Segment>& hanging, const Work& work);

}  // namespace cwm::perception
