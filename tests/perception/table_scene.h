// Objects placed on a table, as a Kinect sees them.
#pragma once

#include <string>

#include "perception/interpret_scene.h"
#include "perception/simulation/virtual_scanner.h"

namespace cwm::perception {

// A camera at 1.1 m that looks 35 degrees down at the origin, which is on the table. Its view is
// along x.
PinholeCamera TableCamera();

SimulatedObject Table();
SimulatedObject MakeObject(const std::string& name, const Shape& shape, const Pose& X_WO);

// Scans and interprets the scene with the camera's pose given; fails the test if there is no
// interpretation.
SceneInterpretation Interpreted(const SimulatedScene& scene);

}  // namespace cwm::perception
