// The wall of a vessel: a surface of revolution about an upright axis, whatever its profile, seen
// from outside, from inside, or both. What shells of open vessels are made about (shell_fit.h);
// what stands out from it is fixed to it.
#pragma once

#include <vector>

#include "perception/cloud/oriented_points.h"
#include "perception/cloud/work.h"

namespace cwm::perception {

// Most of the walls of cups, pans and jugs for a table.
inline constexpr double kWallThickness_m = 0.006;

struct RevolvedWall {
  Vector2 foot = Vector2::Zero();  // where the axis meets z = middle_z_m of the level frame
  Vector2 lean = Vector2::Zero();  // of the axis, metres per metre upwards
  double middle_z_m = 0;
  double low_z_m = 0, high_z_m = 0;    // the heights between which the wall is seen
  double step_m = 0;                   // of the profile
  std::vector<double> outer_radius_m;  // profile: the middles of the steps from low_z_m up

  Vector2 AxisAt(double z_m) const { return foot + (z_m - middle_z_m) * lean; }
  // Of the outside at a height; beyond the ends that of the nearer end.
  double OuterRadius_m(double z_m) const;
  // How far a point lies outside the wall, level and away from the axis; negative within.
  double StandsOut_m(const Vector3& p) const;
};

// The walls of one object, that of most points first: mostly one; several where vessels touch.
// Robust to what stands out. A wall's points agree on it by their place, within three standard
// deviations, and their normal: half of those that are steep, through 60 degrees about the axis, if
// it is the first; else a quarter of them (that are on no wall before), through 180 degrees. Where
// only the inside is in view, the outside is taken to lie as far out as walls are thick.
std::vector<RevolvedWall> FitRevolvedWalls(const OrientedPoints& points, const Work& work);

}  // namespace cwm::perception
