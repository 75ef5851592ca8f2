// Computes how much of each object the others hide from a camera.
#pragma once

#include <vector>

#include "perception/simulation/simulated_scene.h"

namespace cwm::perception {

// Per object, the share of the pixels of its own silhouette in which another object is nearer. 1 if
// the object would not be visible even alone.
std::vector<double> HiddenShares(const SimulatedScene& scene, const PinholeCamera& camera);

}  // namespace cwm::perception
