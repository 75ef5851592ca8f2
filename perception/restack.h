// Flat things stacked on each other: of what the upper ones leave of the lower, strips and corners are seen.
#pragma once

#include <vector>

#include "perception/model_thing.h"

namespace cwm::perception {

// Of boxes that touch: where one is not all that its object shows, or begins in the air where others end,
// or reaches into another, cuts the points of all at the heights of the level faces that are seen, and
// makes an object of what is between two, resting on that below. Kept where each layer is one box and lies
// over the one below it. `modelled` are the scene's things, one for one. Throws
// Stopped when `work` is stopped.
void Restack(const InterpretOptions& options, const Work& work, SegmentedScene& scene,
             std::vector<ModelledThing>& modelled);

}  // namespace cwm::perception
