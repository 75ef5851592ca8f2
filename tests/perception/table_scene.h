// Things placed on a table, as a Kinect sees them.
#pragma once

#include <string>

#include "perception/interpret_scene.h"
#include "perception/simulation/virtual_scanner.h"

namespace cwm::perception {

// From 1.1 m, 35 degrees down, onto the origin, which is on the table. Its view is along x.
PinholeCamera TableCamera();

SimulatedObject Table();
SimulatedObject Thing(const std::string& name, const Shape& shape, const Pose& X_WO);

// With the camera's pose given; fails the test where there is none.
SceneInterpretation Interpreted(const SimulatedScene& scene);

}  // namespace cwm::perception
