// Vessels for the table, tilted, as they lie on one.
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

// Tilted about y, then turned about z; its lowest point on z = 0, its middle above the origin. At a
// tilt of 90 it opens to x, turned by 180 to -x, where cameras of tests are.
SimulatedObject TiltedVessel(const VesselWall& wall, double tilt_deg, double yaw_deg);

// Between unit vectors.
double AngleBetween_deg(const Vector3& a, const Vector3& b);

}  // namespace cwm::perception
