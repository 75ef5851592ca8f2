// Merges the walls of an open box, seen from inside and outside, and its floor, which is too near
// to the support to be distinguished from it.
#pragma once

#include <memory>

#include "perception/refinement/pass.h"

namespace cwm::perception {

// Proposes a tray where single walls are the sides of an open box (FindTrays) and rays pass through
// its mouth. Everything on its sides and its floor, including the support's points within it,
// becomes one object with a box for each side and the floor. An unseen side is COMPLETED, or left
// out if rays pass it. Objects in the tray then rest on it. Proposes nothing if not all points were
// seen from one place.
std::unique_ptr<const RefinementPass> MakeMergeTrayWalls();

}  // namespace cwm::perception
