// Round solids that end where rays were seen to pass.
#pragma once

#include <span>

#include "perception/fit/solid.h"

namespace cwm::perception {

// What is seen of a wall tells its curvature, and rays over its far rim how far it reaches; real
// depth cameras contradict themselves there. Over far rims of lids they show the background,
// several pixels wide; and an image that is computed with a focal length a share e too short is too
// wide by e, which makes the radius of an arc that faces the sensor too large by 2 e. Cylinders and
// cones give way to the rays: they are narrowed, the side that faces the sensor staying where it
// was measured, by as little as leaves a third of the rays in them and by at most 5 % of the
// radius; not at all where that does not clear a third of them. The underside of what lies rises by
// up to twice as much: nobody saw it. By as much as a coefficient moves its standard deviation
// grows.
void YieldToRays(const FitContext& context, std::span<Solid> solids);

}  // namespace cwm::perception
