#include "tests/perception/model/tilted_vessels.h"

#include <algorithm>
#include <cmath>

namespace cwm::perception {

VesselWall MugWall() {
  return {.outer = {{0.036, 0}, {0.04, 0.095}}, .wall_m = 0.004, .floor_m = 0.005};
}
VesselWall PanWall() {
  return {.outer = {{0.09, 0}, {0.1, 0.06}}, .wall_m = 0.003, .floor_m = 0.004};
}
VesselWall GlassWall() {
  return {.outer = {{0.03, 0}, {0.03, 0.14}}, .wall_m = 0.003, .floor_m = 0.005};
}
VesselWall BowlWall() {
  VesselWall bowl{.outer = {}, .wall_m = 0.004, .floor_m = 0.006};
  for (int k = 0; k <= 12; ++k) {
    const double turn_rad = 90 * kDegree_rad * k / 12;
    bowl.outer.push_back({.radius_m = 0.03 + 0.045 * std::sin(turn_rad),
                          .height_m = 0.06 * (1 - std::cos(turn_rad))});
  }
  return bowl;
}

SimulatedObject TiltedVessel(const VesselWall& wall, double tilt_deg, double yaw_deg) {
  SimulatedObject object;
  object.name = "vessel";
  object.parts = {{.shape = MakeMesh(MakeVessel(wall))}};
  object.X_WO.linear() = (Eigen::AngleAxisd(yaw_deg * kDegree_rad, Vector3::UnitZ()) *
                          Eigen::AngleAxisd(tilt_deg * kDegree_rad, Vector3::UnitY()))
                             .matrix();
  const Aabb bounds = TightBounds(object.parts[0].shape, object.X_WO);
  object.X_WO.translation() << -bounds.center().head<2>(), -bounds.min().z();
  return object;
}

double AngleBetween_deg(const Vector3& a, const Vector3& b) {
  return std::acos(std::clamp(a.dot(b), -1.0, 1.0)) / kDegree_rad;
}

}  // namespace cwm::perception
