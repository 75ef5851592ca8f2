// Clouds that are no images any more.
#pragma once

#include <cstdint>

#include "perception/simulation/virtual_scanner.h"

namespace cwm::perception {

// The points that returned, with their truth, in an order drawn at random: height 1.
SimulatedCloud Shuffled(const SimulatedCloud& scan, std::uint64_t seed);

// An up vector that is off by this angle, in a direction drawn at random, in frame C.
Vector3 UpOffBy(double error_rad, const Pose& X_WC, std::uint64_t seed);

}  // namespace cwm::perception
