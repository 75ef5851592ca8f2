// Tilted vessels, as they lie on a table.
#pragma once

#include <numbers>

#include "perception/simulation/simulated_scene.h"
#include "perception/simulation/vessel_meshes.h"

namespace cwm::perception {

inline constexpr double kDegree_rad = std::numbers::pi / 180;

VesselWall MugWall();
VesselWall PanWall();
VesselWall GlassWall();
VesselWall BowlWall();

// The vessel is tilted about y and then turned about z; its lowest point is on z = 0, its middle
// above the origin. With a tilt of 90 degrees it opens towards x; turned by 180 degrees, towards
// -x, where the tests' cameras are.
SimulatedObject TiltedVessel(const VesselWall& wall, double tilt_deg, double yaw_deg);

// The angle between two unit vectors, in degrees.
double AngleBetween_deg(const Vector3& a, const Vector3& b);

}  // namespace cwm::perception
