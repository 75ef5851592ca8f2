// Frames of two sensors that come late, twice, in another order or not at all, against the
// processed ones alone.
#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "perception/simulation/deliveries.h"
#include "tests/benchmarks/live/live_benchmarks.h"
#include "tests/benchmarks/live/live_scenes.h"
#include "tests/benchmarks/live/live_world.h"
#include "tests/benchmarks/live/world_bytes.h"
#include "tests/benchmarks/running_server.h"
#include "tests/benchmarks/server/server_benchmarks.h"

namespace cwm::benchmarks {
namespace {

constexpr int kSensors = 2, kThings = 6;
constexpr double kBegin_s = 1, kDuration_s = 3.1;  // one push
constexpr int kMaxRuns = 1'000, kRunsOfAScene = 2;
constexpr int kScale = 2;  // smaller images than those of the other figures

struct Sent {
  std::size_t sensor = 0;
  std::size_t frame = 0;
  double delivery_s = 0;
};

// A thing is pushed, before two cameras.
perception::SequenceScript PushedBeforeTwo() {
  perception::SequenceScript script = PushedThing(
      kBegin_s, {.thing_count = kThings, .duration_s = kDuration_s, .sensor_count = kSensors});
  ScaleDown(kScale, script);
  return script;
}

// The frames in the order in which they come; the choices follow from the seed.
std::vector<Sent> InDisorder(perception::SequenceScript script, std::uint64_t seed) {
  script.seed = seed;
  std::vector<Sent> sent;
  for (std::size_t i = 0; i < script.sensors.size(); ++i) {
    perception::SequenceSensor& sensor = script.sensors[i];
    sensor.lost.rate = 0.1;
    sensor.doubled.rate = 0.15;
    sensor.late.rate = 0.1;
    sensor.swapped.rate = 0.15;
    sensor.latency_s = 0.01 * static_cast<double>(i);
    for (const perception::FrameDelivery& delivery : perception::FrameDeliveries(script, i)) {
      sent.push_back({.sensor = i,
                      .frame = static_cast<std::size_t>(delivery.frame),
                      .delivery_s = delivery.delivery_s});
    }
  }
  std::ranges::stable_sort(sent, {}, &Sent::delivery_s);
  return sent;
}

struct Run {
  std::optional<WorldBytes> world = {};  // empty after a failure
  std::vector<Sent> processed = {};
  int refused = 0;
};

// Sends each frame when the one before is answered and what it began is interpreted, to a server
// on so many cores; 0: all.
Run Send(const std::vector<std::vector<TrueFrame>>& frames, const std::vector<Sent>& sent,
         int cores) {
  LiveWorld world({.cores = cores});
  if (!world.up()) return {};
  std::vector<LiveSensor*> sensors;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    sensors.push_back(&world.AddSensor("camera_" + std::to_string(i + 1), frames[i].front().frame));
  }
  Run run;
  for (const Sent& each : sent) {
    const auto answer =
        SendAndSettle(world, *sensors[each.sensor], frames[each.sensor][each.frame].frame);
    if (!answer) return {};
    if (answer->is_processed()) run.processed.push_back(each);
    run.refused += answer->response.fate() == v1::FRAME_FATE_REFUSED;
  }
  run.world = BytesOf(world.server().connection(), kLiveWorld);
  return run;
}

// Two runs with the frames in one disorder, on one core and on all, and one with the frames that
// these have processed.
bool MeasureDisorder(const std::vector<std::vector<TrueFrame>>& frames,
                     const std::vector<Sent>& sent, SceneSamples& samples, Report& report) {
  const Run disordered = Send(frames, sent, 1);
  const Run again = Send(frames, sent, 0);
  const Run alone = Send(frames, disordered.processed, 0);
  for (const Run* run : {&disordered, &again, &alone}) {
    if (!run->world) {
      report.Fail("a stream in disorder ended, or its world is empty");
      return false;
    }
  }
  if (alone.refused > 0) {
    report.Fail("a frame that was processed before was refused among its equals alone");
    return false;
  }
  for (const Run* run : {&disordered, &again}) {
    const bool is_different = *run->world != *alone.world;
    samples.Add("different", is_different ? 1 : 0);
    samples.Add("refused", run->refused);
    samples.Add("objects", static_cast<double>(run->world->objects.size()));
    samples.Add("revision", std::stod(run->world->revision));
    if (is_different) report.Detail("  differs: " + FirstDifference(*run->world, *alone.world));
  }
  return true;
}

}  // namespace

void MeasureLiveOrder(const SceneOptions& options, Report& report) {
  const perception::SequenceRenderer renderer(PushedBeforeTwo());
  std::vector<std::vector<TrueFrame>> frames;
  for (std::size_t i = 0; i < kSensors; ++i) {
    frames.push_back(RenderFrames(renderer, i, 0, static_cast<int>(kDuration_s * 30)));
  }
  MoveToPast(frames);
  const auto samples = MeasureScenes(
      options, "order", kMaxRuns / kRunsOfAScene, report, [&](int scene, SceneSamples& scenes) {
        return MeasureDisorder(frames,
                               InDisorder(renderer.script(), 1 + static_cast<std::uint64_t>(scene)),
                               scenes, report);
      });
  if (!samples) return;
  report.Add(WithLimit(
      {.key = "live_order",
       .value = samples->Sum("different"),
       .unit = "1",
       .how =
           "of " + std::to_string(samples->Of("different").size()) +
           " runs with late, doubled, swapped and lost frames of two sensors, half of them on "
           "one core, those whose objects or events differ in a byte from those of the processed "
           "frames "
           "alone; median " +
           std::to_string(static_cast<int>(Median(samples->Of("refused")))) + " refused frames, " +
           std::to_string(static_cast<int>(Median(samples->Of("revision")))) + " revisions and " +
           std::to_string(static_cast<int>(Median(samples->Of("objects")))) + " objects a run"},
      0));
}

}  // namespace cwm::benchmarks
