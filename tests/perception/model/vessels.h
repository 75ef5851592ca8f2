// Points of open mugs without noise, as one sensor sees them, for the tests of vessels.
#pragma once

#include "perception/cloud/oriented_points.h"

namespace cwm::perception {

inline constexpr double kMugRadius_m = 0.04, kMugHeight_m = 0.1, kMugWall_m = 0.004;

// Appends the points that a sensor at `points.viewpoint` would see of a mug that stands on z = 0
// around `axis`: the near half of the outside and the far half of the inside, 2 mm apart.
void AddMug(const Vector2& axis, OrientedPoints& points);

// Appends the half of a tube of `thickness_m` along the middle line that faces the sensor. Its
// normals are zero, because hardly any can be estimated on thin objects.
void AddTube(const std::vector<Vector3>& middle, double thickness_m, OrientedPoints& points);

// The middle line of an ear: from the wall of a mug around the z axis towards y and back, 30 mm
// out.
std::vector<Vector3> Ear();

}  // namespace cwm::perception
