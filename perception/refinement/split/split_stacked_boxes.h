// Splits stacks of flat boxes of which only corners are visible: if touching objects made of boxes
// are not in order, the stack is cut again at the heights of its level faces.
#pragma once

#include <memory>

#include "perception/refinement/pass.h"

namespace cwm::perception {

// Touching objects of boxes that are not in order (one of them is not one box, begins in the air,
// or runs through another) are replaced by one box for each height at which level faces end, each
// on the one before, if each is one box and lies over the one below.
std::unique_ptr<const RefinementPass> MakeSplitStackedBoxes();

}  // namespace cwm::perception
