// What stands before an object cuts it in two. Where the shape of a part suggests it, and nobody saw
// through between them, one solid is fitted to both: they are one object when it accounts for them.
#pragma once

#include <memory>

#include "perception/refinement/pass.h"

namespace cwm::perception {

// Proposes nothing where not all was seen from one place.
std::unique_ptr<const RefinementPass> MakeMergeOccludedParts();

}  // namespace cwm::perception
