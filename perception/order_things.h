// Things and their models, brought into order together.
#pragma once

#include <cstddef>
#include <vector>

#include "perception/model_thing.h"

namespace cwm::perception {

// Of the things, these come first; residuals follow.
std::size_t CountObjects(const SegmentedScene& scene);

// What hides its foot is not what a thing stands on, where it was modelled as reaching the support.
void StandAsModelled(const std::vector<ModelledThing>& modelled, SegmentedScene& scene);

// Objects by the size that they have now, as SegmentedScene::things promises; `modelled` are the scene's
// things, one for one, and what rests on something keeps resting on it. Residuals stay where they are.
void SortBySize(SegmentedScene& scene, std::vector<ModelledThing>& modelled);

}  // namespace cwm::perception
