// Tables of separate things, of clutter and of vessels.
#pragma once

#include "perception/simulation/random_scenes.h"

namespace cwm::perception {

// As random_scenes.h says of each family.
SimulatedView RandomTableView(std::uint64_t seed);
SimulatedView RandomClutterView(std::uint64_t seed);
SimulatedView RandomVesselView(std::uint64_t seed);

}  // namespace cwm::perception
