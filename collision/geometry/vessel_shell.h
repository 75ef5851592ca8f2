// Open vessels such as bowls, cups, pans and jugs: a solid of revolution about z with a wall, a
// rim, a floor and a hollow inside. Collision engines use its mesh; grasp planning reads its rim.
#pragma once

#include <optional>
#include <vector>

#include "collision/geometry/triangle_mesh.h"

namespace cwm {

// The profile runs through points (radial, z): up the outside, over the rim, down the inside. All
// radial coordinates are positive except the last of the inside, which is 0 (the middle of the
// floor). Centred like a cone: the foot lies at z = -height/2, the rim at z = +height/2.
struct VesselShell {
  std::vector<Vector2> outer;   // from the edge of the foot to the rim
  std::vector<Vector2> inner;   // from the rim to the middle of the floor
  double wall_thickness_m = 0;  // perpendicular to the wall
  // One standard deviation of each; absent if the value was assumed, not measured.
  std::optional<double> rim_radius_sigma_m = std::nullopt;
  std::optional<double> wall_thickness_sigma_m = std::nullopt;

  double rim_radius_m() const { return outer.back().x(); }  // outer radius
  double foot_radius_m() const { return outer.front().x(); }
  double height_m() const { return outer.back().y() - outer.front().y(); }
  double depth_m() const { return inner.front().y() - inner.back().y(); }  // from rim to floor

  friend bool operator==(const VesselShell&, const VesselShell&) = default;
};

// Exact signed distance of p from the shell's surface, in metres: negative in the wall and the
// floor, positive in the hollow.
double SignedDistance_m(const VesselShell& shell, const Vector3& p);

// A watertight, outward-wound mesh, inscribed in the outer and in the inner surface and no farther
// than `max_deviation_m` from either, as far as kMaxSegments (tessellate.h) allows.
TriangleMesh Tessellate(const VesselShell& shell, double max_deviation_m);

}  // namespace cwm
