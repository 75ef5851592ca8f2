// Things that are parts of others.
#pragma once

#include <cstddef>
#include <vector>

#include "perception/scene/segment_scene.h"

namespace cwm::perception {

// Makes each thing one with that which it is given to, itself where it stays: what they are given to
// may be given on, in no circle. Things without points are dropped; objects stay before residuals,
// largest first, and what rested on a thing rests on what that was given to.
void GiveThings(std::vector<std::size_t> given_to, std::vector<SegmentedThing>& things);

}  // namespace cwm::perception
