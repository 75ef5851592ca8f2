// The walls of an open box that show their inside, those that show their outside, and its floor, which
// is too near to what it stands on to be told from that, are one object.
#pragma once

#include <memory>

#include "perception/refinement/pass.h"

namespace cwm::perception {

// Where lone walls are sides of an open box (FindTrays) and one sees into its mouth, what lies on its
// sides and its floor becomes one object, of the points of its support those within it among them: a
// box for each side and for the floor. A side that nobody saw is COMPLETED, or left out where rays
// pass. What stands in it rests on it. Proposes nothing where not all was seen from one place.
std::unique_ptr<const RefinementPass> MakeMergeTrayWalls();

}  // namespace cwm::perception
