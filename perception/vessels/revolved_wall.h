// The wall of a vessel: a surface of revolution about any axis, whatever its profile, seen from
// outside, from inside, or both. What shells of open vessels are made about (shell_fit.h); what
// stands out from it is fixed to it.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "perception/cloud/oriented_points.h"
#include "perception/cloud/tolerances.h"
#include "perception/cloud/work.h"
#include "perception/fit/refine.h"

namespace cwm::perception {

// chosen: most of the walls of cups, pans and jugs for a table are no thicker.
inline constexpr double kWallThickness_m = 0.006;

// chosen: of an object so many points are searched. Neighbouring pixels err together, so that it
// loses little: a face of 60 measured points keeps 20 of them in an object of 12 000.
inline constexpr std::size_t kSearchPoints = 4000;
// chosen: points or rays that tell a share or a gap: a share of 5 % is known to 1.1 %.
inline constexpr std::size_t kMaxLookedAt = 400;
// chosen: walls of one object, fits whose axes are asked, turns of a frame to its axis. The first
// walls and fits are those of most points, and an axis is nearly linear about its frame.
inline constexpr std::size_t kMaxTries = 4;

// derived: half an independent sample, of a ring of the wall.
inline constexpr std::size_t kMinInRing = kOneSample / 2;
// derived: 60 degrees, of a wall or its ring: a handle that points at the sensor fills two sectors.
inline constexpr int kMinSectors = kSectors / 6;
// chosen: steps of the profile, 18 mm, that tell of one place: a handle's width, and noise.
inline constexpr std::size_t kNearSteps = 3;

// In the wall's frame W, whose z is nearly its axis and whose origin is that of L: L itself for vessels
// that stand.
struct RevolvedWall {
  Matrix3 R_LW = Matrix3::Identity();
  Vector2 foot = Vector2::Zero();  // where the axis meets z = middle_z_m
  Vector2 lean = Vector2::Zero();  // of the axis, metres per metre upwards
  double middle_z_m = 0;
  double low_z_m = 0, high_z_m = 0;    // the heights between which the wall is seen
  double step_m = 0;                   // of the profile
  std::vector<double> outer_radius_m;  // profile: the middles of the steps from low_z_m up

  Vector2 AxisAt(double z_m) const { return foot + (z_m - middle_z_m) * lean; }
  // Unit, in L.
  Vector3 Axis() const { return R_LW * Vector3(lean.x(), lean.y(), 1).normalized(); }
  // On the axis, half-way up what is seen, in L.
  Vector3 Middle() const { return R_LW * Vector3(foot.x(), foot.y(), middle_z_m); }
  // Of the outside at a height; beyond the ends that of the nearer end.
  double OuterRadius_m(double z_m) const;
  // How far a point of L lies outside the wall, away from the axis; negative within.
  double StandsOut_m(const Vector3& p_L) const;
};

// The upright walls of one object, that of most points first: mostly one; several where vessels touch.
// Robust to what stands out. A wall's points agree on it by their place, within three standard
// deviations, and their normal: half of those that are steep, through 60 degrees about the axis, if
// it is the first; else a quarter of them (that are on no wall before), through 180 degrees. Where
// only the inside is in view, the outside is taken to lie as far out as walls are thick.
std::vector<RevolvedWall> FitRevolvedWalls(const OrientedPoints& points, const Work& work);

// The first of such walls about another axis, whose z points as that does. Held, the axis is taken to be
// known as well as up is; free, it is where the wall's own normals and rings lead from there, which is
// nowhere for a ball's.
std::optional<RevolvedWall> FitRevolvedWall(const OrientedPoints& points, const Vector3& axis_L,
                                            AxisFreedom freedom, const Work& work);

}  // namespace cwm::perception
