// Finds the wall below a disc that was found first. Little more than its lid is visible of a cup
// seen from above, but the lid's edge constrains the wall better than the few points of the wall
// could.
#pragma once

#include <optional>
#include <vector>

#include "perception/fit/shape_fit.h"

namespace cwm::perception {

// Returns the cylinder or cone whose rim is the edge of `disc`, a plane, and that most of the
// available points behind the disc lie on. Empty if the edge is no circle (a square's is not), or
// if fewer than two independent samples show a wall.
std::optional<ShapeFit> FindWallBehindDisc(const ShapeFit& disc, const FitContext& context,
                                           const std::vector<char>& available);

}  // namespace cwm::perception
