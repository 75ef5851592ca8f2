// Things that touch, of which one has points of the other.
#pragma once

#include <vector>

#include "perception/model_thing.h"

namespace cwm::perception {

// Of objects beside each other, gives one what no shape of it explains, or what is a handle of it, but
// lies on a shape of the other, or begins and ends there, and models both anew; keeps that where fewer
// points are left without a shape. Walls of mugs that touch are taken for each other's, and a handle for
// that of what it touches. `modelled` are the scene's things, one for one, and stay in order.
void TradePoints(const InterpretOptions& options, const Work& work, SegmentedScene& scene,
                 std::vector<ModelledThing>& modelled);

}  // namespace cwm::perception
