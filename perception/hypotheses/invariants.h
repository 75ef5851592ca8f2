// Invariants that every SceneState keeps after any pass.
#pragma once

#include <string>
#include <vector>

#include "perception/hypotheses/scene_state.h"

namespace cwm::perception {

// Returns one sentence per broken invariant; empty for a sound state:
//   - every point belongs to exactly one hypothesis or support, or is rejected;
//   - the hypothesis below another exists, stands on the same support, and there are no cycles;
//   - a model has a label for each point, of an existing shape or handle;
//   - hypotheses are in the order of output.
std::vector<std::string> ViolatedInvariants(const SceneState& state);

}  // namespace cwm::perception
