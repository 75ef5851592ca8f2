// Fits open vessels as shells with outside, rim, inside and floor, never as filled solids (paper,
// introduction: shapes supply the surface that is not seen).
#pragma once

#include <optional>
#include <vector>

#include "perception/solids/solid_assembly.h"
#include "perception/vessels/revolved_wall.h"

namespace cwm::perception {

// Returns the shell about the wall's axis. Empty if too little of the inside was seen, in depth and
// around the axis, to distinguish it from a dent, or if rays pass through the shell. The wall has
// one thickness throughout: it is measured where both sides are seen at the same height, else it is
// typical of walls. Unseen parts are supplied: the outside from the inside, the wall down to the
// support, and a floor as thick as the wall. The role is COMPLETED if most of the surface, except
// that of the foot, was supplied.
std::optional<Solid> FitShell(const RevolvedWall& wall, const FitContext& context);

// Adds the shells of the walls to the assembly. Each replaces the solids that mostly lie on it, if
// it explains clearly more points than they do. The contents of a vessel stay beside it.
void ReplaceByShells(const std::vector<RevolvedWall>& walls, const FitContext& context,
                     Assembly& assembly);

}  // namespace cwm::perception
