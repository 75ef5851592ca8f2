// Merges the walls of a lying vessel. Rims and corners divide it into outside, inside and floor,
// and segmentation does not know its axis (it joins standing vessels: segmentation/join_vessels).
// Touching hypotheses that make one shell are one object.
#pragma once

#include <memory>

#include "perception/refinement/pass.h"

namespace cwm::perception {

std::unique_ptr<const RefinementPass> MakeMergeVesselWalls();

}  // namespace cwm::perception
