// Open vessels as shells: outside, rim, inside and floor, never a plug (paper, introduction: shapes
// supply the surface that is not seen).
#pragma once

#include <optional>
#include <vector>

#include "perception/solids/solid_assembly.h"
#include "perception/vessels/revolved_wall.h"

namespace cwm::perception {

// The shell about the wall's axis. Nothing where the inside was not seen, deep and round enough to
// tell it from a dent, or where rays run through the shell. Of one wall thickness throughout:
// measured where both sides are in view at one height, else as thick as walls are. What is not seen
// is supplied: the outside from the inside, the wall down to what the vessel stands on, a floor as
// thick as the wall. COMPLETED where most of its surface, that of the foot aside, was supplied.
std::optional<Solid> FitShell(const RevolvedWall& wall, const FitContext& context);

// Takes the shells of the walls into the assembly, each in the place of the solids that mostly lie on
// it, where it accounts for clearly more points than these. What a vessel holds remains beside it.
void PreferShells(const std::vector<RevolvedWall>& walls, const FitContext& context,
                  Assembly& assembly);

}  // namespace cwm::perception
