// Tables of things that touch: stacks, heaps, rows; things with lids; things at a table's edge.
#pragma once

#include "perception/simulation/random_scenes.h"

namespace cwm::perception {

// As random_scenes.h says of each family.
SimulatedView RandomStackView(std::uint64_t seed);
SimulatedView RandomHeapView(std::uint64_t seed);
SimulatedView RandomRowView(std::uint64_t seed);
SimulatedView RandomLidView(std::uint64_t seed);
SimulatedView RandomEdgeView(std::uint64_t seed);

}  // namespace cwm::perception
