// Tables with objects that touch (stacks, heaps, rows, filled boxes), objects with lids, or objects
// at an edge.
#pragma once

#include "perception/simulation/random_scenes.h"

namespace cwm::perception {

// Views of these families (random_scenes.h).
SimulatedView RandomStackView(std::uint64_t seed);
SimulatedView RandomHeapView(std::uint64_t seed);
SimulatedView RandomRowView(std::uint64_t seed);
SimulatedView RandomLidView(std::uint64_t seed);
SimulatedView RandomEdgeView(std::uint64_t seed);
SimulatedView RandomContainerView(std::uint64_t seed);

}  // namespace cwm::perception
