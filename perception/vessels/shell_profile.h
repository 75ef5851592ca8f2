// Builds the closed profile of a vessel's shell from the visible parts of its wall and floor.
#pragma once

#include <optional>
#include <vector>

#include "collision/geometry/vessel_shell.h"

namespace cwm::perception {

// chosen: the thinnest wall and floor of a vessel: sheet metal with lacquer.
inline constexpr double kMinVesselWall_m = 0.0015;

// The wall at one height at which it is seen.
struct WallRing {
  double z_m = 0;
  double radius_m = 0;  // radius of the outside
  double slope = 0;     // change of the radius per metre of height
  double weight = 0;    // number of points of the ring
  bool shows_outside = false, shows_inside = false;
};

// The rings with radii and slopes from straight lines fitted to each ring and its neighbours.
std::vector<WallRing> Smoothed(const std::vector<WallRing>& rings, double step_m);

// The foot of the shell. With kAtSeenEnd it is on the ground only if the visible part ends just
// above it.
enum class ShellFoot { kOnGround, kAtSeenEnd };

// The visible parts of a vessel, in coordinates about its axis.
struct ShellOutline {
  std::vector<WallRing> rings = {};  // upwards, at least one
  std::vector<Vector2> floor = {};   // (radial, z) of the inside, inwards; empty if not seen
  double step_m = 0;                 // between neighbouring rings, and between places of the floor
  double rim_z_m = 0;
  double thickness_m = 0;                           // thickness across the wall
  std::optional<double> ground_z_m = std::nullopt;  // height of the support, which it never enters
  ShellFoot foot = ShellFoot::kOnGround;
};

struct ShellProfile {
  VesselShell shell;
  double middle_z_m = 0;      // height of the shell's origin in the outline's frame
  double measured_share = 0;  // measured share of the area of walls and floor
};

// Returns the shell's profile; empty if no room is left between rim and floor.
std::optional<ShellProfile> MakeShell(const ShellOutline& outline);

}  // namespace cwm::perception
