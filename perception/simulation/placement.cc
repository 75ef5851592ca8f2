#include "perception/simulation/placement.h"

#include <cmath>
#include <numbers>
#include <utility>

#include "perception/simulation/hull_distance.h"

namespace cwm::perception {
namespace {

constexpr double kTurn_rad = 2 * std::numbers::pi;

bool WithinArea(const SimulatedObject& object, const RestingArea& area) {
  const Aabb bounds = BoundsInWorld(object);
  return area.area_W.contains(Eigen::AlignedBox2d(bounds.min().head<2>(), bounds.max().head<2>()));
}

Pose PoseAt(const Vector2& place_W, double top_m, double yaw_rad) {
  return MakePose({place_W.x(), place_W.y(), top_m},
                  Quaternion(Eigen::AngleAxisd(yaw_rad, Vector3::UnitZ())));
}

Vector2 Direction(double angle_rad) { return {std::cos(angle_rad), std::sin(angle_rad)}; }

// True if the object's only body has an upright z axis, as a standing object has.
bool StandsUpright(const SimulatedObject& object) {
  constexpr double kUpright = 1 - 1e-9;
  return std::abs((object.X_WO * object.parts.front().X_FS).linear()(2, 2)) > kUpright;
}

}  // namespace

PlanarPose DrawPlanarPose(const Vector2& middle_W, double radius_m, RandomDraws& draws) {
  const double distance_m = radius_m * std::sqrt(draws.Uniform());
  const Vector2 place_W = middle_W + distance_m * Direction(draws.Uniform(0, kTurn_rad));
  return {.place_W = place_W, .yaw_rad = draws.Uniform(0, kTurn_rad)};
}

std::optional<SimulatedObject> PlaceOnArea(SimulatedObject object, const RestingArea& area,
                                           const PlanarPose& pose) {
  object.X_WO = PoseAt(pose.place_W, area.top_m, pose.yaw_rad);
  if (!WithinArea(object, area)) return std::nullopt;
  return object;
}

Side DrawSide(RandomDraws& draws) {
  const double direction_rad = draws.Uniform(0, kTurn_rad);
  return {.direction_rad = direction_rad, .yaw_rad = draws.Uniform(0, kTurn_rad)};
}

Side DrawLeaningSide(const SimulatedObject& neighbour, RandomDraws& draws) {
  double direction_rad = draws.Uniform(0, kTurn_rad);
  if (std::holds_alternative<Box>(neighbour.parts.front().shape)) {
    const Matrix3 R_WS = (neighbour.X_WO * neighbour.parts.front().X_FS).linear();
    const double face_rad = std::atan2(R_WS(1, 0), R_WS(0, 0));
    direction_rad = face_rad + draws.Below(4) * kTurn_rad / 4;
  }
  return {.direction_rad = direction_rad, .yaw_rad = direction_rad + kTurn_rad / 2};
}

std::optional<SimulatedObject> PushAgainst(SimulatedObject object, const RestingArea& area,
                                           const SimulatedObject& neighbour, const Side& side) {
  constexpr double kStart_m = 0.6;  // clear of the largest objects: half of two diagonals of 0.5 m
  const Vector2 away = Direction(side.direction_rad);
  const Vector2 middle_W = BoundsInWorld(neighbour).center().head<2>();
  object.X_WO = PoseAt(middle_W + kStart_m * away, area.top_m, side.yaw_rad);
  if (!SlideUntilTouching({-away.x(), -away.y(), 0}, neighbour, object)) return std::nullopt;
  if (!WithinArea(object, area)) return std::nullopt;
  return object;
}

bool CanHold(const SimulatedObject& neighbour, const SimulatedObject& object) {
  if (neighbour.is_support || neighbour.parts.size() != 1) return false;
  if (std::holds_alternative<Sphere>(neighbour.parts.front().shape)) return false;
  if (!StandsUpright(neighbour)) return false;
  return BoundsInWorld(neighbour).sizes().z() >= BoundsInWorld(object).center().z();
}

}  // namespace cwm::perception
