// From what is seen of a vessel's wall and floor to the closed profile of its shell.
#pragma once

#include <optional>
#include <vector>

#include "collision/geometry/vessel_shell.h"

namespace cwm::perception {

// chosen: the thinnest wall and floor of a vessel, of sheet metal with its lacquer.
inline constexpr double kMinVesselWall_m = 0.0015;

// A height at which the wall is seen.
struct WallRing {
  double z_m = 0;
  double radius_m = 0;  // of the outside
  double slope = 0;     // of the radius over the height
  double weight = 0;    // points behind it
  bool shows_outside = false, shows_inside = false;
};

// Radii and slopes by straight lines through each ring and its neighbours.
std::vector<WallRing> Smoothed(const std::vector<WallRing>& rings, double step_m);

enum class ShellFoot { kOnGround, kOfWhatIsSeen };  // the latter too where that ends just above it

// About the vessel's axis.
struct ShellOutline {
  std::vector<WallRing> rings = {};  // upwards, at least one
  std::vector<Vector2> floor = {};   // (radial, z) of the inside, inwards; empty: not seen
  double step_m = 0;                 // between neighbouring rings, and between places of the floor
  double rim_z_m = 0;
  double thickness_m = 0;                           // across the wall
  std::optional<double> ground_z_m = std::nullopt;  // what it stands on, and never enters
  ShellFoot foot = ShellFoot::kOnGround;
};

struct ShellProfile {
  VesselShell shell;
  double middle_z_m = 0;      // of the shell's frame in that of the outline
  double measured_share = 0;  // of the walls' and the floor's area: what rings and places bear out
};

// Nothing where no room is left between the rim and the floor.
std::optional<ShellProfile> MakeShell(const ShellOutline& outline);

}  // namespace cwm::perception
