// Objects that stand side by side and are of one height: their fronts are seldom flush.
#pragma once

#include <memory>

#include "perception/refinement/pass.h"

namespace cwm::perception {

// Cuts a box, or an object of several solids, by upright planes where its front jumps or turns
// outward, into parts that each are one solid and stand. A box is cut only where the criterion
// prefers its parts by more than the coincidence costs that they are alike. Proposes nothing where not
// all was seen from one place.
std::unique_ptr<const RefinementPass> MakeSplitRows();

}  // namespace cwm::perception
