// Points on known surfaces, with and without noise, for the tests of the modeler.
#pragma once

#include "perception/cloud/oriented_points.h"
#include "perception/fit/passing_rays.h"
#include "perception/simulation/virtual_scanner.h"

namespace cwm::perception {

// One object on a table at z = 0, seen by a Kinect from `distance_m` away at `elevation_rad` above
// the table, in W: its true points with estimated normals, and the rays that passed it and ended on
// the table.
struct ScannedObject {
  OrientedPoints points;
  PassingRays passing;
  Pose X_WSupport = Pose::Identity();
};
ScannedObject ScanOnTable(const SimulatedObject& object, double distance_m, double elevation_rad,
                          std::uint64_t seed);

SimulatedObject OfOnePart(const Shape& shape, double height_of_center_m);

}  // namespace cwm::perception
