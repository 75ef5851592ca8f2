// Random kitchens.
#pragma once

#include "perception/simulation/random_scenes.h"

namespace cwm::perception {

// A view of SceneFamily::kKitchen (random_scenes.h).
SimulatedView RandomKitchenView(std::uint64_t seed);

}  // namespace cwm::perception
