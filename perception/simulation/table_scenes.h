// Tables with separate objects, clutter, or vessels.
#pragma once

#include "perception/simulation/random_scenes.h"

namespace cwm::perception {

// Views of these families (random_scenes.h).
SimulatedView RandomTableView(std::uint64_t seed);
SimulatedView RandomClutterView(std::uint64_t seed);
SimulatedView RandomVesselView(std::uint64_t seed);

}  // namespace cwm::perception
