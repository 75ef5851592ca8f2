// How much of each object of a scene the others hide from a camera.
#pragma once

#include <vector>

#include "perception/simulation/simulated_scene.h"

namespace cwm::perception {

// Per object: of the pixels in which it would be the first thing seen if it were alone in the
// scene, the share in which something else is nearer. 1 where it would not be seen at all.
std::vector<double> HiddenShares(const SimulatedScene& scene, const PinholeCamera& camera);

}  // namespace cwm::perception
