// Things that touch and are seen as one object: several closed solids, each beside the other.
#pragma once

#include "perception/solids/solid_assembly.h"

namespace cwm::perception {

// Where the options say so and no one solid accounts for nine tenths of an object's points on a
// known ground: cuts them by upright planes, as convex things that stand beside each other can be,
// and replaces the solids by one for each part where every part is accounted for by one, but for a
// tenth of the points, whose own solids stay, none overlaps another, and the criterion prefers them
// together decisively. True where it did.
bool PreferPartedSolids(const FitContext& context, Assembly& assembly);

}  // namespace cwm::perception
