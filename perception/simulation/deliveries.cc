#include "perception/simulation/deliveries.h"

#include <algorithm>

#include "perception/simulation/random_draws.h"

namespace cwm::perception {
namespace {

constexpr double kJustAfter_s = 0.001;
constexpr double kStatesBefore_s = 0.1;

// Streams of the script's seed; each sensor has four.
constexpr std::uint64_t kChoiceStream = 5000;
enum Choice : std::uint64_t { kLost, kDoubled, kLate, kSwapped };

class FrameChooser {
 public:
  FrameChooser(const FrameChoice& choice, std::uint64_t seed, std::uint64_t stream)
      : choice_(choice), draws_(seed, stream) {}

  // Call this once for each frame, in order.
  bool Chooses(int frame) {
    const bool drawn = draws_.Uniform() < choice_.rate;
    return drawn || std::count(choice_.frames.begin(), choice_.frames.end(), frame) > 0;
  }

 private:
  const FrameChoice& choice_;
  RandomDraws draws_;
};

}  // namespace

std::vector<FrameDelivery> FrameDeliveries(const SequenceScript& script, std::size_t sensor_index) {
  const SequenceSensor& sensor = script.sensors[sensor_index];
  const auto chooser = [&](const FrameChoice& choice, Choice which) {
    return FrameChooser(choice, script.seed, kChoiceStream + 4 * sensor_index + which);
  };
  FrameChooser lost = chooser(sensor.lost, kLost);
  FrameChooser doubled = chooser(sensor.doubled, kDoubled);
  FrameChooser late = chooser(sensor.late, kLate);
  FrameChooser swapped = chooser(sensor.swapped, kSwapped);
  std::vector<FrameDelivery> deliveries;
  for (int frame = 0; frame < FrameCount(script, sensor); ++frame) {
    const double moment_s = script.start_stamp_s + FrameTime_s(sensor, frame);
    FrameDelivery delivery{.frame = frame,
                           .stamp_s = moment_s + sensor.clock_offset_s,
                           .delivery_s = moment_s + sensor.latency_s};
    const bool is_lost = lost.Chooses(frame);
    const bool is_doubled = doubled.Chooses(frame);
    if (late.Chooses(frame)) delivery.delivery_s += sensor.late_by_s;
    if (swapped.Chooses(frame)) delivery.delivery_s += 1 / sensor.rate_hz + kJustAfter_s;
    if (is_lost) continue;
    deliveries.push_back(delivery);
    delivery.delivery_s += kJustAfter_s;
    if (is_doubled) deliveries.push_back(delivery);
  }
  std::stable_sort(
      deliveries.begin(), deliveries.end(),
      [](const FrameDelivery& a, const FrameDelivery& b) { return a.delivery_s < b.delivery_s; });
  return deliveries;
}

std::vector<JointStateDelivery> JointStateDeliveries(const SequenceScript& script,
                                                     std::size_t robot_index) {
  const SimulatedRobot& robot = script.robots[robot_index];
  const JointStateStream& stream = robot.states;
  std::vector<JointStateDelivery> deliveries;
  for (int i = 0;; ++i) {
    const double time_s = i / stream.rate_hz - kStatesBefore_s;
    if (time_s > script.duration_s) break;
    const auto covers = [&](const TimeInterval& interval) { return interval.Contains(time_s); };
    if (std::any_of(stream.missing.begin(), stream.missing.end(), covers)) continue;
    double latency_s = stream.latency_s;
    for (const JointStateStream::Late& late : stream.late) {
      if (covers(late.during)) latency_s += late.by_s;
    }
    const double moment_s = script.start_stamp_s + time_s;
    deliveries.push_back({.stamp_s = moment_s + stream.clock_offset_s,
                          .delivery_s = moment_s + latency_s,
                          .values = robot.trajectory.At(time_s)});
  }
  std::stable_sort(deliveries.begin(), deliveries.end(),
                   [](const JointStateDelivery& a, const JointStateDelivery& b) {
                     return a.delivery_s < b.delivery_s;
                   });
  return deliveries;
}

}  // namespace cwm::perception
