// Open boxes with goods in them, and vessels that lie on their side.
#pragma once

#include "perception/simulation/groups.h"
#include "perception/simulation/random_draws.h"

namespace cwm::perception {

// A tray or carton without a lid (15 to 40 cm long, 3 to 16 cm high, walls of 2 to 6 mm) and up to
// three goods that stand on its floor. The first member is the open box: part 0 is its floor, the
// others are its sides.
Group DrawOpenBox(RandomDraws& draws);

// A mug, pan or jug on its side, with its handle level. It opens towards -y.
SimulatedObject DrawLyingVessel(RandomDraws& draws);

}  // namespace cwm::perception
