// Flat boxes on one another that leave only corners of each other to be seen: wherever things of boxes
// touch and are not in order, the stack is cut anew at the heights of its level faces.
#pragma once

#include <memory>

#include "perception/refinement/pass.h"

namespace cwm::perception {

// Objects of boxes that touch and are not in order (one of them is not one box, begins in the air on
// nothing, or runs through another) become a box for each height at which level faces end, each on the
// one before, where each is one box and lies over the one below.
std::unique_ptr<const RefinementPass> MakeSplitStackedBoxes();

}  // namespace cwm::perception
