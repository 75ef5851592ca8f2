// Meshes of open vessels with thick walls, bent handles and spouts. Each is watertight and wound
// outwards.
#pragma once

#include <vector>

#include "collision/geometry/shape.h"

namespace cwm::perception {

// A point of the outer wall: radius about z at a height above the foot.
struct WallPoint {
  double radius_m = 0;
  double height_m = 0;
};

// A vessel about z with its foot at z = 0, open at the top. The outer wall is straight between
// points of increasing height. The inner wall follows it `wall_m` nearer to the axis, from the top
// of the floor upwards, and meets it at a flat rim. All radii are larger than the wall's thickness,
// and the vessel is higher than its floor.
struct VesselWall {
  std::vector<WallPoint> outer;
  double wall_m = 0.003;
  double floor_m = 0.004;
};
TriangleMesh MakeVessel(const VesselWall& wall);

// The outer radius at a height, between that of the foot and of the rim.
double OuterRadius_m(const VesselWall& wall, double height_m);

// A point of a tube whose centre line is in the plane y = 0. The cross-section is an ellipse with
// these half axes: the thickness lies in the plane, the width along y.
struct TubePoint {
  Vector2 place_xz = Vector2::Zero();
  double half_thickness_m = 0;
  double half_width_m = 0;
};

// The tube along the points, closed by flat ends. At least two points, all neighbours distinct;
// bends are wider than the tube's thickness.
TriangleMesh MakeTube(const std::vector<TubePoint>& points);

}  // namespace cwm::perception
