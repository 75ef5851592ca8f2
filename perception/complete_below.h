// What carries another thing reaches up to it, also where that hides its upper end.
#pragma once

#include <vector>

#include "perception/model_thing.h"

namespace cwm::perception {

// Solids that are all of a thing on which another rests, and that end below its foot, are lengthened up to
// it as what hides its own foot is down to the support (complete_hidden.h). `modelled` are the scene's
// things, one for one. Does nothing to scenes without SegmentedScene::sight.
void CompleteBelow(const SegmentedScene& scene, std::vector<ModelledThing>& modelled);

}  // namespace cwm::perception
