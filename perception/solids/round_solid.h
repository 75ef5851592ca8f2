// Spheres, cylinders and cones as bounded solids with their caps.
#pragma once

#include <optional>
#include <vector>

#include "perception/fit/solid.h"

namespace cwm::perception {

// The solid of a curved fit that is seen from outside; nothing for one seen from inside. Cylinders
// and cones reach as far as their inliers do; a disc normal to the axis at an end (one of
// `fits`) is the cap and sets the length: its index joins `used`. Upright ones are completed down
// to the ground when they end just above it.
std::optional<Solid> MakeRoundSolid(const ShapeFit& fit, const std::vector<ShapeFit>& fits,
                                    const FitContext& context, const Ground& ground,
                                    std::vector<char>& used);

// A plate whose edge is a circle, as a cylinder of the same thickness; nothing of others, and where
// too little of the circle is seen.
std::optional<Solid> MakeDisc(const Solid& plate, const FitContext& context);

}  // namespace cwm::perception
