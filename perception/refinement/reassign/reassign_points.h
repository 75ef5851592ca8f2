// Reassigns points between objects that touch: unexplained points that a shape of the neighbour
// explains, and, if the neighbour has a vessel, handles whose ends lie nearer to the neighbour's
// shapes than to their owner's, by more than 10 mm in sum.
#pragma once

#include <memory>

#include "perception/refinement/pass.h"

namespace cwm::perception {

std::unique_ptr<const RefinementPass> MakeReassignPoints();

}  // namespace cwm::perception
