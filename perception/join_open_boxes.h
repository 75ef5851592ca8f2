// The walls of an open box that show their inside, those that show their outside, and its floor, which is
// too near to what it stands on to be told from that, are one thing.
#pragma once

#include <cstddef>
#include <vector>

#include "perception/model_thing.h"

namespace cwm::perception {

// Where lone walls are sides of an open box (FindOpenBoxes) and one sees into its mouth, what lies on
// its sides and its floor becomes one thing, of the points of its support those within it among them:
// a box for each side and for the floor. A side that nobody saw is COMPLETED, or left out where rays pass.
// What stands in it rests on it. `modelled` are the scene's things, one for one. Returns the supports that
// lost points. Does nothing to scenes without SegmentedScene::sight,
// or where all that stands on a support is one thing.
std::vector<std::size_t> JoinOpenBoxes(const InterpretOptions& options, const Work& work,
                                       SegmentedScene& scene, std::vector<ModelledThing>& modelled);

}  // namespace cwm::perception
