// Things and their models, brought into order together.
#pragma once

#include <vector>

#include "perception/model_thing.h"

namespace cwm::perception {

// Objects by the size that they have now, as SegmentedScene::things promises; `modelled` are the scene's
// things, one for one, and what rests on something keeps resting on it. Residuals stay where they are.
void SortBySize(SegmentedScene& scene, std::vector<ModelledThing>& modelled);

}  // namespace cwm::perception
