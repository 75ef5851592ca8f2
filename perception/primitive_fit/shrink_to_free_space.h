// Narrows round solids that reach into free space.
#pragma once

#include <span>

#include "perception/fit/solid.h"

namespace cwm::perception {

// Narrows cylinders and cones that more rays enter than mixed pixels explain. The points of a wall
// constrain its curvature and rays over its far rim constrain its width, and real depth cameras are
// inconsistent there: over far rims of lids they show several pixels of background, and an image
// that is interpreted with a focal length too short by a share e is too wide by e, which makes the
// radius of an arc facing the sensor too large by 2 e.
//
// The side that faces the sensor stays where it was measured. The radius shrinks by the smallest
// step that leaves at most a third of the rays inside, and by at most 5 %; if no step clears a
// third of the rays, the solid stays. The underside of a lying solid, which nobody saw, rises by up
// to twice as much. The standard deviation of each coefficient grows by its change.
void ShrinkToFreeSpace(const FitContext& context, std::span<Solid> solids);

}  // namespace cwm::perception
