// Splits an object that is several touching ones: closed solids side by side.
#pragma once

#include "perception/solids/solid_assembly.h"

namespace cwm::perception {

// Does nothing unless the options ask for it, the ground is known, and the object is not explained
// by a single solid already. Cuts the points by upright planes, which is enough for convex objects
// side by side, and fits one closed solid to each part. Replaces the solids of the assembly, and
// returns true, if together these solids explain at least kNearlyAll of the points, none overlaps
// another, no ray contradicts them, and the criterion prefers them by a margin
// (kMaxValueRatioToSeveral, kMaxValueRatioToOne). Solids of the assembly that explain points which
// no part explains are kept.
bool ReplaceBySplitSolids(const FitContext& context, Assembly& assembly);

}  // namespace cwm::perception
