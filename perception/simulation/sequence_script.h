// A script of a sequence: the scene, what moves in it and when, and the sensors that watch. Plain
// values; the state at any time follows from them alone.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "perception/cloud/sensor_noise.h"
#include "perception/simulation/simulated_scene.h"

namespace cwm::perception {

// A pose at a time of the script, which begins at 0.
struct TimedPose {
  double time_s = 0;
  Pose X_WB = Pose::Identity();
};

// The pose at a time: straight and at constant speed between neighbours, with the shortest
// rotation; the first pose before, the last one after. `waypoints` is not empty, its times ascend.
Pose InterpolatePose(const std::vector<TimedPose>& waypoints, double time_s);

// The values of a robot's variables over time, linear between neighbours, constant before and
// after. One row of values per time.
struct JointTrajectory {
  std::vector<double> times_s = {};  // ascending; not empty
  std::vector<std::vector<double>> rows = {};

  std::vector<double> At(double time_s) const;
};

// [begin_s, end_s)
struct TimeInterval {
  double begin_s = 0;
  double end_s = 0;

  bool Contains(double time_s) const { return time_s >= begin_s && time_s < end_s; }
};

// The joint states that a robot reports.
struct JointStateStream {
  double rate_hz = 100;
  double clock_offset_s = 0;  // added to the stamps
  double latency_s = 0;       // from the moment of a state to its delivery
  std::vector<TimeInterval> missing = {};
  struct Late {
    TimeInterval during = {};
    double by_s = 0;
  };
  std::vector<Late> late = {};
};

struct SimulatedRobot {
  std::string name = {};
  // One body per link, with its parts in the link's frame.
  std::vector<SimulatedObject> links = {};
  std::vector<std::string> variables = {};  // their names, in the order of the trajectory's rows
  // X_WL of each link for the values of the variables.
  std::function<std::vector<Pose>(std::span<const double> values)> link_poses = {};
  JointTrajectory trajectory = {};
  JointStateStream states = {};
};

// A hand with its forearm, which is there from its first waypoint to its last.
struct SimulatedHand {
  std::string name = {};
  SimulatedObject shape = {};
  std::vector<TimedPose> waypoints = {};  // X_WH, see hand.h; times ascend

  bool IsPresent(double time_s) const {
    return !waypoints.empty() && time_s >= waypoints.front().time_s &&
           time_s <= waypoints.back().time_s;
  }
};

// Indices into the script's robots and their links.
struct LinkRef {
  std::size_t robot = 0;
  std::size_t link = 0;
  friend bool operator==(const LinkRef&, const LinkRef&) = default;
};
// An index into the script's hands.
struct HandRef {
  std::size_t hand = 0;
  friend bool operator==(const HandRef&, const HandRef&) = default;
};
using Carrier = std::variant<LinkRef, HandRef>;

// Moves on a straight line from where it is to X_WO.
struct MoveEvent {
  Pose X_WO = Pose::Identity();
};
// Keeps its place in the carrier's frame.
struct CarryEvent {
  Carrier carrier = {};
};
struct VanishEvent {};  // is gone from the event's begin on
struct AppearEvent {    // is there from the event's begin on
  Pose X_WO = Pose::Identity();
};

struct ObjectEvent {
  std::size_t object = 0;  // index into the scene's objects
  double begin_s = 0;
  double end_s = 0;  // not used for objects that appear or vanish
  std::variant<MoveEvent, CarryEvent, VanishEvent, AppearEvent> what = {};
};

// How a sensor is mounted.
struct MountedOnLink {
  LinkRef link = {};
  Pose X_LC = Pose::Identity();
};
using SensorMount = std::variant<Pose, std::vector<TimedPose>, MountedOnLink>;

// Which frames something happens to: those named, and each other one with a probability.
struct FrameChoice {
  std::vector<int> frames = {};
  double rate = 0;
};

struct SequenceSensor {
  std::string name = {};
  SensorNoise noise = {};
  PinholeCamera camera = {};  // its X_WC is not used
  SensorMount mount = Pose::Identity();
  double rate_hz = 30;
  double start_s = 0;         // time of the first frame
  double clock_offset_s = 0;  // added to the stamps
  double latency_s = 0;       // from the moment of a frame to its delivery
  std::uint64_t device_seed = 1;
  FrameChoice lost = {};
  FrameChoice doubled = {};
  FrameChoice late = {};
  double late_by_s = 0.05;
  FrameChoice swapped = {};  // delivered just after their successor
};

struct SequenceScript {
  // Objects at their places of time 0. One whose first event is AppearEvent is not there before.
  SimulatedScene scene = {};
  double duration_s = 1;
  double start_stamp_s = 1000;  // the stamp of time 0
  std::uint64_t seed = 1;       // of all that differs from frame to frame
  std::vector<SequenceSensor> sensors = {};
  std::vector<SimulatedRobot> robots = {};
  std::vector<SimulatedHand> hands = {};
  // The events of one object do not overlap; ascending in time for each object.
  std::vector<ObjectEvent> events = {};
};

// The number of frames that a sensor takes, lost ones included: one at start_s + k / rate_hz for
// each k while that is less than the duration.
int FrameCount(const SequenceScript& script, const SequenceSensor& sensor);
inline double FrameTime_s(const SequenceSensor& sensor, int frame) {
  return sensor.start_s + frame / sensor.rate_hz;
}

struct ObjectState {
  Pose X_WO = Pose::Identity();
  bool is_present = true;
  bool is_moving = false;
  std::optional<Carrier> carrier = {};
};

// Everything that has a place at one moment.
struct SequenceState {
  std::vector<ObjectState> objects = {};
  std::vector<std::vector<double>> joint_values = {};  // by robot
  std::vector<std::vector<Pose>> X_WL = {};            // by robot and link
  std::vector<std::optional<Pose>> X_WH = {};          // by hand; empty: not there
};
SequenceState StateAt(const SequenceScript& script, double time_s);

// The place of one object, as in StateAt.
ObjectState ObjectStateAt(const SequenceScript& script, std::size_t object, double time_s);

// The camera of the sensor at a time, with its true pose.
PinholeCamera CameraAt(const SequenceScript& script, const SequenceSensor& sensor, double time_s);

}  // namespace cwm::perception
