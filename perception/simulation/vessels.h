// Mugs, pans and jugs of random size; handles and spouts are parts of the object.
#pragma once

#include "perception/simulation/random_draws.h"
#include "perception/simulation/simulated_scene.h"

namespace cwm::perception {

enum class VesselKind { kMug, kPan, kJug };

// Half of them are mugs, the others pans and jugs.
VesselKind DrawVesselKind(RandomDraws& draws);

// Part 0 is the body, part 1 the handle, and part 2 the spout of a jug; each is a mesh with its
// role. Handles are 5 to 15 mm thick: a bow on the wall of mugs (reaching out 22 to 40 mm) and jugs
// (30 to 55 mm), a bar of 120 to 200 mm at the rim of pans. The object stands with z up on z = 0
// and the handle towards x; X_WO is the identity.
SimulatedObject DrawVessel(VesselKind kind, RandomDraws& draws);

}  // namespace cwm::perception
