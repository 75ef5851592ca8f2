// The wall below a disc that was found first: of a cup seen from above little else than its lid
// shows, but where the lid ends tells what the few points of the wall alone could not.
#pragma once

#include <optional>
#include <vector>

#include "perception/fit/shape_fit.h"

namespace cwm::perception {

// The cylinder or cone whose rim is the edge of `disc`, a plane, and that most of the available
// points behind it lie on. Nothing when the edge is no circle (a square's is not), or when fewer
// than two independent samples show a wall.
std::optional<ShapeFit> WallBehindDisc(const ShapeFit& disc, const FitContext& context,
                                       const std::vector<char>& available);

}  // namespace cwm::perception
