// How well the edges of a box are known.
#pragma once

#include <vector>

#include "perception/fit/solid.h"

namespace cwm::perception {

// One standard deviation of each of the box's three sizes, metres; 0 where an end of it was not
// seen. Empty for other shapes. An end is seen as a
// face, as an outline with free space beyond it, or where the box stands on its support; the slow
// warp moves both ends, the more alike the nearer they are.
std::vector<double> BoxSizeSigmas(const Solid& box, const FitContext& context);

}  // namespace cwm::perception
