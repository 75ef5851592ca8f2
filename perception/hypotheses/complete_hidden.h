// Completes the hidden lower part of a solid down to the object's ground (paper, introduction and
// figure 2).
#pragma once

#include <vector>

#include "collision/geometry/hybrid_model.h"
#include "perception/cloud/oriented_points.h"
#include "perception/segmentation/sight_map.h"

namespace cwm::perception {

// An object's points and its ground, in the level frame.
struct StandingThing {
  const OrientedPoints& points;
  const Pose& X_LSupport;  // z = 0 is the top of the ground, z up
};

// Lengthens upright boxes, cylinders and cones that end above the object's ground down to it, and
// marks them COMPLETED, if
//   - nearly all of the added wall that faces the sensor lies behind something nearer or in
//     directions without a return, and no ray but those of mixed pixels passed through any of it
//     (or just inside it where it faces away from the sensor);
//   - the object has no points below the solid except on that wall; they would be its ground.
// Their observed fraction becomes that of the longer solid. A solid that ends within 3 mm of the
// ground is marked COMPLETED, without a change, if the same holds for 30 mm or more of its foot
// that no point lies on. Solids that lie, lean, or end below the ground stay as they are. `shapes`
// are in the level frame.
void CompleteHidden(const StandingThing& thing, const SightMap& sight,
                    std::vector<ShapePart>& shapes);

}  // namespace cwm::perception
