// Random kitchens.
#pragma once

#include "perception/simulation/random_scenes.h"

namespace cwm::perception {

// SceneFamily::kKitchen, as random_scenes.h says.
SimulatedView RandomKitchenView(std::uint64_t seed);

}  // namespace cwm::perception
