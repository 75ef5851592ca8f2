#include "perception/simulation/hand.h"

#include <algorithm>
#include <array>
#include <utility>

namespace cwm::perception {
namespace {

// cited: a hand of an adult is 190 mm long and 85 mm across the palm, fingers are 16 mm thick (DIN
// 33402-2, medians).
constexpr double kFingerRadius_m = 0.008, kThumbRadius_m = 0.010, kPalmRadius_m = 0.014;
constexpr double kWristRadius_m = 0.028, kForearmRadius_m = 0.040;
constexpr double kKnuckles_m = -0.085, kWrist_m = -0.180, kForearm_m = -0.220, kElbow_m = -0.460;
constexpr std::array<double, 4> kFingers_m = {-0.031, -0.010, 0.010, 0.031};  // across the palm

constexpr double kMinOpening_m = 0.02, kMaxOpening_m = 0.11;
constexpr double kGraspDepth_m = 0.04;  // of the tips below the top of what they grasp
constexpr double kHold_s = 0.1;         // between contact and going

Placed<> CapsuleBetween(const Vector3& a, const Vector3& b, double radius_m) {
  const Vector3 along = b - a;
  Pose X_HS = Pose::Identity();
  X_HS.linear() = BasisFromZ(along.normalized());
  X_HS.translation() = 0.5 * (a + b);
  return {.X_FS = X_HS, .shape = Capsule{.radius_m = radius_m, .length_m = along.norm()}};
}

Aabb BoundsAt(const SequenceScript& script, std::size_t object, const Pose& X_WO) {
  SimulatedObject placed = script.scene.objects[object];
  placed.X_WO = X_WO;
  return BoundsInWorld(placed);
}

Vector3 GraspPoint(const Aabb& bounds) {
  const double depth_m = std::min(kGraspDepth_m, 0.5 * bounds.sizes().z());
  return {bounds.center().x(), bounds.center().y(), bounds.max().z() - depth_m};
}

SimulatedObject HandFor(const Aabb& bounds) {
  return MakeHand(std::clamp(bounds.sizes().head<2>().minCoeff(), kMinOpening_m, kMaxOpening_m));
}

// The hand with its tips at a point, having come straight from another one.
Pose HandAt(const Vector3& tips_W, const Vector3& from_W) {
  Pose X_WH = Pose::Identity();
  X_WH.linear() = BasisFromZ((tips_W - from_W).normalized());
  X_WH.translation() = tips_W;
  return X_WH;
}

Pose MovedTo(const Vector3& tips_W, const Pose& X_WH) {
  Pose moved = X_WH;
  moved.translation() = tips_W;
  return moved;
}

}  // namespace

SimulatedObject MakeHand(double opening_m) {
  SimulatedObject hand{.name = "hand"};
  const double half_m = 0.5 * opening_m;
  for (const double x_m : kFingers_m) {
    hand.parts.push_back(CapsuleBetween({x_m, half_m + kFingerRadius_m, 0},
                                        {x_m, 0.01, kKnuckles_m}, kFingerRadius_m));
    hand.parts.push_back(
        CapsuleBetween({x_m, 0, kKnuckles_m}, {0.7 * x_m, 0, kWrist_m}, kPalmRadius_m));
  }
  hand.parts.push_back(
      CapsuleBetween({0, -half_m - kThumbRadius_m, 0}, {-0.03, -0.02, -0.11}, kThumbRadius_m));
  hand.parts.push_back(CapsuleBetween({0, 0, kWrist_m}, {0, 0, kForearm_m}, kWristRadius_m));
  hand.parts.push_back(CapsuleBetween({0, 0, kForearm_m}, {0, 0, kElbow_m}, kForearmRadius_m));
  return hand;
}

Vector3 ReachFrom(const SequenceScript& script, std::size_t object, double time_s) {
  const Aabb bounds = BoundsAt(script, object, ObjectStateAt(script, object, time_s).X_WO);
  return bounds.center() + Vector3(0.1, 0.2, 0.5 * bounds.sizes().z() + 0.6);
}

void TakeByHand(std::size_t object, double time_s, const HandReach& reach, SequenceScript& script) {
  const Aabb bounds = BoundsAt(script, object, ObjectStateAt(script, object, time_s).X_WO);
  const Pose grasp = HandAt(GraspPoint(bounds), reach.from_W);
  const Pose away = MovedTo(reach.from_W, grasp);
  const double lift_s = time_s + kHold_s;
  const double end_s = lift_s + reach.travel_s;
  const HandRef hand{script.hands.size()};
  script.hands.push_back(
      {.name = reach.name,
       .shape = HandFor(bounds),
       .waypoints = {
           {time_s - reach.travel_s, away}, {time_s, grasp}, {lift_s, grasp}, {end_s, away}}});
  script.events.push_back(
      {.object = object, .begin_s = lift_s, .end_s = end_s, .what = CarryEvent{.carrier = hand}});
  script.events.push_back(
      {.object = object, .begin_s = end_s, .end_s = end_s, .what = VanishEvent{}});
}

void PutByHand(std::size_t object, double time_s, const Pose& X_WO, const HandReach& reach,
               SequenceScript& script) {
  const Aabb bounds = BoundsAt(script, object, X_WO);
  const Pose grasp = HandAt(GraspPoint(bounds), reach.from_W);
  const Pose away = MovedTo(reach.from_W, grasp);
  const double begin_s = time_s - reach.travel_s;
  const HandRef hand{script.hands.size()};
  script.hands.push_back({.name = reach.name,
                          .shape = HandFor(bounds),
                          .waypoints = {{begin_s, away},
                                        {time_s, grasp},
                                        {time_s + kHold_s, grasp},
                                        {time_s + kHold_s + reach.travel_s, away}}});
  script.events.push_back({.object = object,
                           .begin_s = begin_s,
                           .end_s = begin_s,
                           .what = AppearEvent{away * grasp.inverse() * X_WO}});
  script.events.push_back(
      {.object = object, .begin_s = begin_s, .end_s = time_s, .what = CarryEvent{.carrier = hand}});
}

void PushByHand(std::size_t object, const TimeInterval& during, const Pose& X_WO,
                const HandReach& reach, SequenceScript& script) {
  const Pose start = ObjectStateAt(script, object, during.begin_s).X_WO;
  const Aabb bounds = BoundsAt(script, object, start);
  const Vector3 by = X_WO.translation() - start.translation();
  Vector3 contact = bounds.center();
  if (const double length_m = by.head<2>().norm(); length_m > 0) {
    const Vector2 direction = by.head<2>() / length_m;
    // The side of the bounds that lies opposite to the direction, less what the fingers need.
    const double side_m = 0.5 * bounds.sizes().head<2>().dot(direction.cwiseAbs()) + kPalmRadius_m;
    contact.head<2>() -= side_m * direction;
  }
  const Pose touch = HandAt(contact, reach.from_W);
  const Pose away = MovedTo(reach.from_W, touch);
  script.hands.push_back({.name = reach.name,
                          .shape = MakeHand(kMinOpening_m),
                          .waypoints = {{during.begin_s - reach.travel_s, away},
                                        {during.begin_s, touch},
                                        {during.end_s, MovedTo(contact + by, touch)},
                                        {during.end_s + reach.travel_s, away}}});
  script.events.push_back({.object = object,
                           .begin_s = during.begin_s,
                           .end_s = during.end_s,
                           .what = MoveEvent{X_WO}});
}

}  // namespace cwm::perception
