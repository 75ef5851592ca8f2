// Points of open mugs without noise, as one sensor sees them, for the tests of vessels.
#pragma once

#include "perception/cloud/oriented_points.h"

namespace cwm::perception {

inline constexpr double kMugRadius_m = 0.04, kMugHeight_m = 0.1, kMugWall_m = 0.004;

// Appends to `points` what a sensor at `points.viewpoint` would see of a mug that stands on z = 0
// around `axis`: the near half of the outside, the far half of the inside, 2 mm apart.
void AddMug(const Vector2& axis, OrientedPoints& points);

// Appends a tube of `thickness_m` along the middle line: the half of it that faces the sensor, with
// zero normals, which thin things hardly have.
void AddTube(const std::vector<Vector3>& middle, double thickness_m, OrientedPoints& points);

// From the wall of a mug around the z axis towards y and back to it, 30 mm out.
std::vector<Vector3> Ear();

}  // namespace cwm::perception
