// Rims and corners cut a vessel that lies into its outside, its inside and its floor; segmentation
// does not know its axis (it joins those that stand: scene/join_vessels). Hypotheses that touch and
// make one shell are one object.
#pragma once

#include <memory>

#include "perception/refinement/pass.h"

namespace cwm::perception {

std::unique_ptr<const RefinementPass> MakeMergeVesselWalls();

}  // namespace cwm::perception
