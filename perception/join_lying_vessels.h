// Rims and corners cut a vessel that lies into its outside, its inside and its floor, whose axis
// segmentation does not know (it joins those that stand: scene/join_vessels). Where things that touch
// make one shell, they are one thing.
#pragma once

#include <vector>

#include "perception/model_thing.h"

namespace cwm::perception {

// `modelled` are the scene's things, one for one; of those that are joined, one is modelled anew and
// the others are gone. Throws Stopped when `work` is stopped.
void JoinLyingVessels(const InterpretOptions& options, const Work& work, SegmentedScene& scene,
                      std::vector<ModelledThing>& modelled);

}  // namespace cwm::perception
