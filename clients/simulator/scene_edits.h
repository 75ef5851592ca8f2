// SceneEdits of a scene on the command line.
#pragma once

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "collision/geometry/pose.h"
#include "perception/simulation/virtual_scanner.h"

namespace cwm::simulator {

struct SceneEdits {
  std::vector<std::string> without;  // names
  std::vector<std::string> moves;    // "NAME=dx,dy,dz", metres along the world's axes
};

// INVALID_ARGUMENT with the edit if it cannot be parsed; NOT_FOUND lists the scene's names.
absl::Status ApplyEdits(const SceneEdits& edits, perception::SimulatedScene& scene);

}  // namespace cwm::simulator
