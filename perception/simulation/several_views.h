// One scene seen from several places, with the clouds merged like registered ones.
#pragma once

#include <vector>

#include "perception/simulation/virtual_scanner.h"

namespace cwm::perception {

struct RegisteredViews {
  SimulatedCloud cloud;    // in frame C of the first camera, unorganised, only returns
  std::vector<Pose> X_WC;  // the true pose of each camera
  std::vector<Pose> X_CC;  // each camera in the first one, with the error of registration
};

// Cameras stand on an arc of 80 degrees about the vertical through the place that the given camera
// looks at; that camera is the first. Every other view is registered with an error of 2 to 5 mm in
// a random direction and 0.2 to 0.5 degrees about a random axis through that place. Each view has
// its own noise. There must be at least one view.
RegisteredViews ScanFromSeveralViews(const SimulatedScene& scene, const PinholeCamera& camera,
                                     int view_count, const ScanOptions& options);

}  // namespace cwm::perception
