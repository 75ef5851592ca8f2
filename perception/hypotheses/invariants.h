// Rules that every SceneState keeps, whatever passes did to it.
#pragma once

#include <string>
#include <vector>

#include "perception/hypotheses/scene_state.h"

namespace cwm::perception {

// One sentence for each rule that is broken, none of a sound state:
//   - every point is of exactly one hypothesis or support, or rejected;
//   - what a hypothesis rests on lives, stands on the same support, and carries it in no circle;
//   - a model has a label for each point, of a shape or handle that it has;
//   - hypotheses are in the order of output.
std::vector<std::string> BrokenInvariants(const SceneState& state);

}  // namespace cwm::perception
