// Fixed and random scenes: the demo's kitchen counter and random tables.
#pragma once

#include <cstdint>

#include "perception/simulation/simulated_scene.h"

namespace cwm::perception {

// The scene of the demo: a kitchen counter on its cabinet before a wall, with boxes, cans, a ball,
// a cup and a mug with a handle; and a camera 0.9 m away at 45 degrees. World: floor at z = 0, top
// of the counter at z = 0.9.
SimulatedScene KitchenCounter();
PinholeCamera KitchenCamera();

// A random table (object 0) with `object_count` boxes, cylinders, spheres and cups, each of one
// part, that do not touch each other, in view of KitchenCamera. Fewer objects if the table is full
// (about 15).
SimulatedScene RandomTable(std::uint64_t seed, int object_count);

}  // namespace cwm::perception
