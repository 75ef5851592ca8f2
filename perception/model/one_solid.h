// The last word on an object: whether one closed solid, fitted to all of its points, accounts for
// them better than the solids that were assembled wall by wall and face by face.
#pragma once

#include <vector>

#include "perception/model/solid_assembly.h"

namespace cwm::perception {

// Whether one of them lies by a quarter or more in another, deeper than noise puts it: no two things
// are in one place.
bool AnyOverlap(const std::vector<Solid>& solids);

// Replaces the solids of an object on a known ground by one where the criterion prefers it
// decisively, no ray contradicts it, and it is not of the kind that the object is already. Solids that
// overlap account for nothing.
void PreferOneSolid(const FitContext& context, Assembly& assembly);

}  // namespace cwm::perception
