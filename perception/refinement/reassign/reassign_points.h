// Reassigns points between objects that touch: points that only a shape of the neighbour explains,
// and handles with their ends on the neighbour's wall.
#pragma once

#include <memory>

#include "perception/refinement/pass.h"

namespace cwm::perception {

std::unique_ptr<const RefinementPass> MakeReassignPoints();

}  // namespace cwm::perception
