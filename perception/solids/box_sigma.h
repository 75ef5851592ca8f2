// Standard deviations of the sizes of a box.
#pragma once

#include <vector>

#include "perception/fit/solid.h"

namespace cwm::perception {

// The standard deviation of each of the box's three sizes, in metres; 0 if one of the two ends was
// not seen. Empty for other shapes. An end is seen as a face, as an outline with free space beyond
// it, or as the foot where the box stands on its support. The slow warp moves both ends, and the
// more alike the nearer they are.
std::vector<double> BoxSizeSigmas(const Solid& box, const FitContext& context);

}  // namespace cwm::perception
