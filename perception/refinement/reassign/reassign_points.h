// Objects that touch give each other points back: those that no shape of their owner explains and a
// shape of the neighbour does, and handles whose ends are on the neighbour's wall.
#pragma once

#include <memory>

#include "perception/refinement/pass.h"

namespace cwm::perception {

std::unique_ptr<const RefinementPass> MakeReassignPoints();

}  // namespace cwm::perception
