// An open vessel as what it is: a bowl, cup, pan or jug is a solid of revolution about z with a wall,
// a rim and a floor, and nothing inside. Engines know it as its mesh; who grasps reads its rim.
#pragma once

#include <optional>
#include <vector>

#include "collision/geometry/triangle_mesh.h"

namespace cwm {

// The profile runs through points (radial, z): up the outside, over the rim, down the inside. All
// radials are positive but the inside's last, which is 0: the middle of the floor. Centred, as a
// cone is: the foot lies at z = -height/2, the rim at z = +height/2.
struct VesselShell {
  std::vector<Vector2> outer;   // from the edge of the foot to the rim
  std::vector<Vector2> inner;   // from the rim to the middle of the floor
  double wall_thickness_m = 0;  // across the wall
  // One standard deviation; absent where that was not measured but supplied.
  std::optional<double> rim_radius_sigma_m = std::nullopt;
  std::optional<double> wall_thickness_sigma_m = std::nullopt;

  double rim_radius_m() const { return outer.back().x(); }  // of the outside
  double foot_radius_m() const { return outer.front().x(); }
  double height_m() const { return outer.back().y() - outer.front().y(); }
  double depth_m() const { return inner.front().y() - inner.back().y(); }  // from rim to floor

  friend bool operator==(const VesselShell&, const VesselShell&) = default;
};

// From the shell's surface, negative in its wall and its floor; positive in what it holds. Exact.
double SignedDistance_m(const VesselShell& shell, const Vector3& p);

// Watertight, outward-wound, inscribed in the outside and in the inside; no farther than
// `max_deviation_m` from either.
TriangleMesh Tessellate(const VesselShell& shell, double max_deviation_m);

}  // namespace cwm
