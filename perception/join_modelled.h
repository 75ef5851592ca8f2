// What stands before a thing cuts it in two. Where the shapes of the parts suggest it, and nobody saw
// through between them, one solid is fitted to both: they are one thing when it accounts for them. A
// part that was taken for the handle of something else is given back so too.
#pragma once

#include <vector>

#include "perception/model_thing.h"

namespace cwm::perception {

// `modelled` are the scene's things, one for one; of those that are joined, the first is modelled
// anew and the second is gone; those between which a handle moves are both modelled anew. Does nothing
// to scenes without SegmentedScene::sight. Throws Stopped when `work` is stopped.
void JoinModelled(const InterpretOptions& options, const Work& work, SegmentedScene& scene,
                  std::vector<ModelledThing>& modelled);

}  // namespace cwm::perception
