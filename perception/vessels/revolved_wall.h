// The wall of a vessel: a surface of revolution about any axis, with any profile, seen from
// outside, from inside, or both. Shells of open vessels are built about it (shell_fit.h); points
// that stand out from it may be handles.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "perception/cloud/oriented_points.h"
#include "perception/cloud/tolerances.h"
#include "perception/cloud/work.h"
#include "perception/fit/refine.h"

namespace cwm::perception {

// chosen: most walls of cups, pans and jugs for a table are no thicker.
inline constexpr double kWallThickness_m = 0.006;

// chosen: points of an object that are searched. Errors of neighbouring pixels are correlated, so
// little is lost: a face of 60 measured points keeps 20 of them in an object of 12 000.
inline constexpr std::size_t kSearchPoints = 4000;
// chosen: points or rays that are enough to estimate a share or a gap: a share of 5 % is known to
// 1.1 %.
inline constexpr std::size_t kMaxComparedPoints = 400;
// chosen: the largest number of walls of one object, of fits whose axes are tried, and of turns of
// a frame to its axis. The first walls and fits have most points, and the fit is nearly linear in
// the axis.
inline constexpr std::size_t kMaxTries = 4;

// derived: points of a ring of the wall, half an independent sample.
inline constexpr std::size_t kMinInRing = kOneSample / 2;
// derived: sectors of a wall or ring that must be seen, 60 degrees: a handle that points at the
// sensor fills two.
inline constexpr int kMinSectors = kSectors / 6;
// chosen: steps of the profile, 18 mm, that count as one place: the width of a handle, and noise.
inline constexpr std::size_t kNearSteps = 3;

// A wall in its frame W, whose z is nearly the axis and whose origin is that of L. For standing
// vessels W is L itself.
struct RevolvedWall {
  Matrix3 R_LW = Matrix3::Identity();
  Vector2 foot = Vector2::Zero();  // where the axis meets z = middle_z_m
  Vector2 lean = Vector2::Zero();  // lean of the axis, metres per metre upwards
  double middle_z_m = 0;
  double low_z_m = 0, high_z_m = 0;    // the wall is seen between these heights
  double step_m = 0;                   // height of a step of the profile
  std::vector<double> outer_radius_m;  // the profile, at the middle of each step, upwards

  Vector2 AxisAt(double z_m) const { return foot + (z_m - middle_z_m) * lean; }
  // The direction of the axis, a unit vector in L.
  Vector3 Axis() const { return R_LW * Vector3(lean.x(), lean.y(), 1).normalized(); }
  // The point of the axis half-way up the visible part, in L.
  Vector3 Middle() const { return R_LW * Vector3(foot.x(), foot.y(), middle_z_m); }
  // The radius of the outside at a height; beyond the ends, that of the nearer end.
  double OuterRadius_m(double z_m) const;
  // The distance of a point of L outside the wall, away from the axis; negative within.
  double Protrusion_m(const Vector3& p_L) const;
};

// Returns the upright walls of one object, the one of most points first: usually one, several if
// vessels touch. Parts that stand out do not disturb them. The points of a wall agree with it in
// position, within three standard deviations, and in normal. The first wall needs half of the steep
// points over 60 degrees about the axis, or, like all later ones, a quarter of the steep points
// (that are on no earlier wall) over 180 degrees. If only the inside is seen, the outside is
// assumed one wall thickness farther out.
std::vector<RevolvedWall> FitRevolvedWalls(const OrientedPoints& points, const Work& work);

// Returns the first such wall about another axis, with z along it. If the axis is held, it is as
// certain as up is; if it is free, the normals and rings of the wall refine it. A ball leads to no
// axis.
std::optional<RevolvedWall> FitRevolvedWall(const OrientedPoints& points, const Vector3& axis_L,
                                            AxisFreedom freedom, const Work& work);

}  // namespace cwm::perception
