// Solids that reach as far as the surface they were fitted to is seen.
#pragma once

#include <vector>

#include "perception/fit/solid.h"

namespace cwm::perception {

// A solid ends where the connected patch that it was fitted to does. What stands before it can hide
// the middle of a wall and show its end again, or leave of the end less than there is of the
// middle: boxes, cylinders and cones are lengthened to the points of the same object that lie on
// their surface prolonged, look as it does and are on no other of the solids, where no more rays
// run through what is added than noise accounts for. Not below the ground.
void ReachOwnPoints(const FitContext& context, std::vector<Solid>& solids);

}  // namespace cwm::perception
