// Meshes of open vessels and of what is fixed to them: walls that have a thickness, bent handles,
// spouts. Each is watertight and wound outwards.
#pragma once

#include <vector>

#include "collision/geometry/shape.h"

namespace cwm::perception {

// A place of the outer wall: radius about z at a height above the foot.
struct WallPoint {
  double radius_m = 0;
  double height_m = 0;
};

// A vessel about z, its foot on z = 0, open at the top. The outer wall runs straight from point to
// point, heights rising; the inner wall follows it `wall_m` nearer to the axis, from the floor's
// thickness up, and meets it at a flat rim. All radii are larger than the wall is thick, and the
// vessel is higher than its floor is thick.
struct VesselWall {
  std::vector<WallPoint> outer;
  double wall_m = 0.003;
  double floor_m = 0.004;
};
TriangleMesh MakeVessel(const VesselWall& wall);

// The outer radius at a height, between that of the foot and of the rim.
double OuterRadius_m(const VesselWall& wall, double height_m);

// A place along a tube whose middle runs in the plane y = 0: its cross-section is an ellipse of
// these half axes, the thickness lying in the plane, the width along y.
struct TubePoint {
  Vector2 place_xz = Vector2::Zero();
  double half_thickness_m = 0;
  double half_width_m = 0;
};

// The tube along the points, closed by flat ends. At least two points, neighbours apart; bends are
// wider than the tube is thick.
TriangleMesh MakeTube(const std::vector<TubePoint>& points);

}  // namespace cwm::perception
