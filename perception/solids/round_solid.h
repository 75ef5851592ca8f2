// Builds bounded spheres, cylinders and cones with their caps.
#pragma once

#include <optional>
#include <vector>

#include "perception/fit/solid.h"

namespace cwm::perception {

// Returns the solid of a curved fit that is seen from outside; empty for one seen from inside.
// Cylinders and cones reach as far as their inliers do. A disc among `fits` that is normal to the
// axis at an end is the cap: it sets the length, and its index is marked in `used`. Upright solids
// that end just above the ground are extended to it.
std::optional<Solid> MakeRoundSolid(const ShapeFit& fit, const std::vector<ShapeFit>& fits,
                                    const FitContext& context, const Ground& ground,
                                    std::vector<char>& used);

// Returns a plate with a circular edge as a cylinder of the same thickness; empty for other solids,
// and if too little of the circle is seen.
std::optional<Solid> MakeDisc(const Solid& plate, const FitContext& context);

}  // namespace cwm::perception
