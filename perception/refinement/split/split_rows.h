// Splits objects of equal height that stand side by side: their fronts are seldom flush.
#pragma once

#include <memory>

#include "perception/refinement/pass.h"

namespace cwm::perception {

// Cuts a box, or an object of several solids, by upright planes where its front jumps or turns
// outward, if each part is one solid that stands. A single box is only cut if the criterion prefers
// its parts by more than the cost of the coincidence that they are alike. Proposes nothing if not
// all points were seen from one place.
std::unique_ptr<const RefinementPass> MakeSplitRows();

}  // namespace cwm::perception
