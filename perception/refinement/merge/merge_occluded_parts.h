// Merges parts of an object that something before it divides. If the shape of a part suggests it,
// and the places between the parts are hidden (VisibilityBetween), one solid is fitted to both:
// they are one object if it accounts for both.
#pragma once

#include <memory>

#include "perception/refinement/pass.h"

namespace cwm::perception {

// Proposes nothing if not all points were seen from one place.
std::unique_ptr<const RefinementPass> MakeMergeOccludedParts();

}  // namespace cwm::perception
