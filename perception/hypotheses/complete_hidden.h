// The part of a solid that something nearer hides, supplied down to what the object stands on
// (paper, introduction and figure 2).
#pragma once

#include <vector>

#include "collision/geometry/hybrid_model.h"
#include "perception/cloud/oriented_points.h"
#include "perception/segmentation/sight_map.h"

namespace cwm::perception {

// An object's points and what they stand on, in the level frame.
struct StandingThing {
  const OrientedPoints& points;
  const Pose& X_LSupport;  // z = 0 is the top of what it stands on, z up
};

// Upright boxes, cylinders and cones that end above what the object stands on are lengthened down
// to it, and COMPLETED from then on, when
//   - nearly all of the wall so supplied that faces the sensor lies behind something nearer, or in
//     directions in which nothing was measured, and no ray passed through any of it, or just inside
//     of what does not face the sensor, but what mixed pixels account for;
//   - the object shows nothing of its own below the solid, which would be what it stands on, but on
//     that wall.
// Their observed fraction is from then on that of the longer solid. What ends within 3 mm of it
// already is COMPLETED as it is where the same is true of 30 mm or more of its foot that no point
// shows; what lies, leans, or ends below stays as it is. `shapes` are in the level frame.
void CompleteHidden(const StandingThing& thing, const SightMap& sight,
                    std::vector<ShapePart>& shapes);

}  // namespace cwm::perception
