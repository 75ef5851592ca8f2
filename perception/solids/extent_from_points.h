// Extends solids as far as their surface is seen.
#pragma once

#include <vector>

#include "perception/fit/solid.h"

namespace cwm::perception {

// A fitted solid ends where the connected patch ends that it was fitted to. An occluder can hide
// the middle of a wall and leave its far end visible, or hide more of the end than of the middle.
// This extends boxes, cylinders and cones to points of the same object that lie on their extended
// surface, agree with its normal, and belong to no other solid. An end stays where it is if the
// extension would reach below the ground or more rays pass through it than noise explains.
void SetExtentFromPoints(const FitContext& context, std::vector<Solid>& solids);

}  // namespace cwm::perception
