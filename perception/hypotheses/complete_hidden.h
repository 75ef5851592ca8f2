// Completes the hidden lower part of a solid down to the object's ground (paper, introduction and
// figure 2).
#pragma once

#include <vector>

#include "collision/geometry/hybrid_model.h"
#include "perception/cloud/oriented_points.h"
#include "perception/segmentation/sight_map.h"

namespace cwm::perception {

// An object's points, and the plane that its solids are completed to, in the level frame.
struct StandingObject {
  const OrientedPoints& points;
  // z = 0 is the plane to reach. z points from it towards the object: up from the ground below, or
  // down from the foot of an object above (CompleteBelow).
  const Pose& X_LSupport;
};

// Extends upright boxes, cylinders and cones that end above the object's ground down to it, and
// marks them COMPLETED, if
//   - at most 15 % of the places on the added wall that face the sensor were seen on a surface, and
//     at most 3 % of all places are seen through (places that face away are tested just inside the
//     wall). The others lie behind something nearer, or in directions without a return;
//   - the object has no points below the solid except on that wall; they would be its ground.
// Their observed fraction becomes that of the longer solid. A solid that ends within 3 mm of the
// ground is marked COMPLETED, without a change, if the same holds for 30 mm or more of its foot
// that no point lies on. Solids that lie, lean, or end below the ground stay as they are. `shapes`
// are in the level frame.
void CompleteHidden(const StandingObject& object, const SightMap& sight,
                    std::vector<ShapePart>& shapes);

}  // namespace cwm::perception
