#include "perception/simulation/sequence_script.h"

#include <algorithm>
#include <cmath>

namespace cwm::perception {
namespace {

// The index of the last time that is not after `time_s`, and how far it is to the next one, in
// [0, 1). `time` returns the time of an element; the first one is not after `time_s`.
struct TrajectoryPlace {
  std::size_t index = 0;
  double share = 0;
};

template <class Time>
TrajectoryPlace FindPlace(std::size_t count, const Time& time, double time_s) {
  if (time_s <= time(0)) return {};
  std::size_t after = 1;
  while (after < count && time(after) <= time_s) ++after;
  if (after == count) return {.index = count - 1};
  const double span_s = time(after) - time(after - 1);
  return {.index = after - 1, .share = (time_s - time(after - 1)) / span_s};
}

Pose Between(const Pose& from, const Pose& to, double share) {
  const Vector3 position = from.translation() + share * (to.translation() - from.translation());
  return MakePose(position, Quaternion(from.linear()).slerp(share, Quaternion(to.linear())));
}

std::vector<Pose> LinkPosesAt(const SimulatedRobot& robot, double time_s) {
  return robot.link_poses(robot.trajectory.At(time_s));
}

// Empty for a hand that is not there.
Pose CarrierPose(const SequenceScript& script, const Carrier& carrier, double time_s) {
  if (const auto* link = std::get_if<LinkRef>(&carrier)) {
    return LinkPosesAt(script.robots[link->robot], time_s)[link->link];
  }
  return InterpolatePose(script.hands[std::get<HandRef>(carrier).hand].waypoints, time_s);
}

// Applies an event that has begun to the state before it.
void Apply(const SequenceScript& script, const ObjectEvent& event, double time_s,
           ObjectState& state) {
  const bool is_over = time_s >= event.end_s;
  if (const auto* move = std::get_if<MoveEvent>(&event.what)) {
    state.is_moving = !is_over;
    const double share = is_over ? 1 : (time_s - event.begin_s) / (event.end_s - event.begin_s);
    state.X_WO = is_over ? move->X_WO : Between(state.X_WO, move->X_WO, share);
  } else if (const auto* carry = std::get_if<CarryEvent>(&event.what)) {
    state.is_moving = !is_over;
    if (!is_over) state.carrier = carry->carrier;
    const Pose X_CO = CarrierPose(script, carry->carrier, event.begin_s).inverse() * state.X_WO;
    state.X_WO = CarrierPose(script, carry->carrier, std::min(time_s, event.end_s)) * X_CO;
  } else if (const auto* appear = std::get_if<AppearEvent>(&event.what)) {
    state.is_present = true;
    state.X_WO = appear->X_WO;
  } else {
    state.is_present = false;
  }
}

}  // namespace

Pose InterpolatePose(const std::vector<TimedPose>& waypoints, double time_s) {
  const TrajectoryPlace place = FindPlace(
      waypoints.size(), [&](std::size_t i) { return waypoints[i].time_s; }, time_s);
  const Pose& from = waypoints[place.index].X_WB;
  return place.share == 0 ? from : Between(from, waypoints[place.index + 1].X_WB, place.share);
}

std::vector<double> JointTrajectory::At(double time_s) const {
  const TrajectoryPlace place = FindPlace(
      times_s.size(), [&](std::size_t i) { return times_s[i]; }, time_s);
  std::vector<double> values = rows[place.index];
  if (place.share == 0) return values;
  for (std::size_t i = 0; i < values.size(); ++i) {
    values[i] += place.share * (rows[place.index + 1][i] - values[i]);
  }
  return values;
}

int FrameCount(const SequenceScript& script, const SequenceSensor& sensor) {
  constexpr double kRounding = 1e-9;  // of a frame that would begin at the end
  const double frames = (script.duration_s - sensor.start_s) * sensor.rate_hz;
  return std::max(0, static_cast<int>(std::ceil(frames - kRounding)));
}

ObjectState ObjectStateAt(const SequenceScript& script, std::size_t object, double time_s) {
  ObjectState state{.X_WO = script.scene.objects[object].X_WO};
  bool is_first = true;
  for (const ObjectEvent& event : script.events) {
    if (event.object != object) continue;
    if (is_first) state.is_present = !std::holds_alternative<AppearEvent>(event.what);
    is_first = false;
    if (event.begin_s <= time_s) Apply(script, event, time_s, state);
  }
  return state;
}

SequenceState StateAt(const SequenceScript& script, double time_s) {
  SequenceState state;
  for (std::size_t i = 0; i < script.scene.objects.size(); ++i) {
    state.objects.push_back(ObjectStateAt(script, i, time_s));
  }
  for (const SimulatedRobot& robot : script.robots) {
    state.joint_values.push_back(robot.trajectory.At(time_s));
    state.X_WL.push_back(robot.link_poses(state.joint_values.back()));
  }
  for (const SimulatedHand& hand : script.hands) {
    state.X_WH.push_back(hand.IsPresent(time_s)
                             ? std::optional(InterpolatePose(hand.waypoints, time_s))
                             : std::nullopt);
  }
  return state;
}

PinholeCamera CameraAt(const SequenceScript& script, const SequenceSensor& sensor, double time_s) {
  PinholeCamera camera = sensor.camera;
  if (const auto* X_WC = std::get_if<Pose>(&sensor.mount)) {
    camera.X_WC = *X_WC;
  } else if (const auto* waypoints = std::get_if<std::vector<TimedPose>>(&sensor.mount)) {
    camera.X_WC = InterpolatePose(*waypoints, time_s);
  } else {
    const auto& mounted = std::get<MountedOnLink>(sensor.mount);
    camera.X_WC = CarrierPose(script, mounted.link, time_s) * mounted.X_LC;
  }
  return camera;
}

}  // namespace cwm::perception
