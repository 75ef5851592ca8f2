// Round objects on one axis, as cans, cups and bowls are stacked: they are one to the segmentation, and
// their solids are those of one object with a step. What could stand alone is an object of its own.
#pragma once

#include <memory>

#include "perception/refinement/pass.h"

namespace cwm::perception {

// Cuts an object of upright solids of revolution where its radius jumps or its wall turns outward, into
// storeys that each rest on the one below. Storeys that are lower or slimmer than what people
// stack are lids, knobs, necks and feet: they stay with the storey below.
std::unique_ptr<const RefinementPass> MakeSplitStackedRounds();

}  // namespace cwm::perception
