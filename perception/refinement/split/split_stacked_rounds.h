// Splits round objects that are stacked on one axis, such as cans, cups and bowls. Segmentation
// makes them one object, whose solids look like those of one object with a step. Parts that could
// stand alone become objects.
#pragma once

#include <memory>

#include "perception/refinement/pass.h"

namespace cwm::perception {

// Cuts an object of upright solids of revolution where its radius jumps or its wall turns outward,
// into storeys that each rest on the one below. Storeys that are lower or slimmer than stacked
// objects are lids, knobs, necks and feet: they stay with the storey below.
std::unique_ptr<const RefinementPass> MakeSplitStackedRounds();

}  // namespace cwm::perception
