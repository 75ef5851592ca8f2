// What an occluder leaves to be seen of a small thing beside a large one is slim and begins at its wall,
// as a handle does. A round solid that stands on the support tells them apart.
#pragma once

#include <vector>

#include "perception/model_thing.h"

namespace cwm::perception {

// `modelled` are the scene's things, one for one. Each handle for which one ball, cylinder or cone that
// touches what its thing stands on accounts becomes an object of its own, and the thing is modelled
// anew without it. Throws Stopped when `work` is stopped.
void ReleaseStanding(const InterpretOptions& options, const Work& work, SegmentedScene& scene,
                     std::vector<ModelledThing>& modelled);

}  // namespace cwm::perception
