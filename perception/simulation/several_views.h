// One scene seen from several places, the clouds put together as registration would.
#pragma once

#include <vector>

#include "perception/simulation/virtual_scanner.h"

namespace cwm::perception {

struct RegisteredViews {
  SimulatedCloud cloud;    // in the frame C of the first camera, unorganised, returns alone
  std::vector<Pose> X_WC;  // where each camera was
  std::vector<Pose> X_CC;  // of each camera in the first one, as registration believes
};

// The cameras stand on an arc of 80 degrees about the vertical through what the given one looks at,
// the given one first. Every view but the first is registered with an error of 2 to 5 mm in a
// random direction and of 0.2 to 0.5 degrees about a random axis through what they look at. Each
// view has noise of its own. At least one view.
RegisteredViews ScanFromSeveral(const SimulatedScene& scene, const PinholeCamera& camera,
                                int view_count, const ScanOptions& options);

}  // namespace cwm::perception
