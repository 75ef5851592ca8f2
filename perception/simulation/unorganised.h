// Turns scans into unorganised clouds, and up vectors into wrong ones.
#pragma once

#include <cstdint>

#include "perception/simulation/virtual_scanner.h"

namespace cwm::perception {

// The points with a return and their ground truth, in random order: height 1.
SimulatedCloud Shuffled(const SimulatedCloud& scan, std::uint64_t seed);

// An up vector in frame C with this angular error in a random direction.
Vector3 PerturbedUp(double error_rad, const Pose& X_WC, std::uint64_t seed);

}  // namespace cwm::perception
